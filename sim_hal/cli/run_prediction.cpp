#include "run_prediction.h"

#include <cmath>

#include "../../firmware/compensation/compensation.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"
#include "../stability/dominant_root.h"
#include "../stability/loop_timeline.h"
#include "../stability/lyapunov.h"
#include "../stability/spectrum.h"

namespace berth
{

namespace
{

/* A longer dead time would make the prediction take more than a moment. */
constexpr int predicted_degree_max = 200;

constexpr std::int64_t predicted_ticks = 40000;

} // namespace

growth_prediction predict_growth(const rig &rig)
try {
    if (rig.object.kind == object_kind::contact) {
        return {{}, "one-sided contact has no small motions, and so no eigenvalues"};
    }
    if (const std::vector<std::string> left_out = left_out_when_small(rig); !left_out.empty()) {
        return {{}, left_out.front()};
    }
    if (compensation_is_on(&rig.firmware) || rig.firmware.arm.kind != ARM_NONE) {
        if (is_time_varying(rig)) {
            return {{},
                    "what changes from period to period is reckoned without compensation and with a manipulator "
                    "of one degree of freedom alone"};
        }
        return {loop_spectrum(without_variation(rig)).growth_per_s, {}};
    }
    const loop_equation equation = make_loop_equation(without_variation(rig));
    if (equation.degree() > predicted_degree_max) {
        return {{},
                "the loop has " + std::to_string(equation.degree()) + " eigenvalues, for more than " +
                    std::to_string(predicted_degree_max) + " ask `berth eigen`"};
    }
    if (is_time_varying(rig)) {
        return {exponent_of(rig, load_wake_histogram(rig), predicted_ticks).growth_per_s, {}};
    }
    return {std::log(dominant_root_finder().spectral_radius(equation)) / config_period_s(&rig.firmware), {}};
} catch (const input_error &error) {
    return {{}, error.what()};
}

} // namespace berth
