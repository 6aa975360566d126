/* Plain functions of the motion and of time, that an error may be made of. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_MOTION_FEATURES_H
#define SIM_HAL_DIAGNOSIS_NOISE_MOTION_FEATURES_H

#include <string_view>
#include <vector>

#include "../replay/block_model.h"

namespace berth
{

/* How an error depends on the motion. */
enum class error_class { linear, odd, even, drift, hysteresis, count };

constexpr std::string_view error_class_names[] = {"linear in the motion", "odd in the motion", "even in the motion",
                                                  "drift over time", "hysteresis or direction of motion"};

struct feature {
    error_class kind;
    std::vector<double> values;
    bool is_constant = false;
    bool is_of_shape = false; /* simulated output and its changes: a lag that is taken for a delay leaves these */
};

/* `error`: of this rig, which was the model's last one. */
std::vector<feature> features_of_motion(const block_model &model, const rig &rig, const std::vector<double> &error);

} // namespace berth

#endif
