/* The whole arm with an object at its tool, let go of from a deflection: nothing linearised, no dead time. How fast
 * it swings and how its swing decays, by how large it is. */
#ifndef SIM_HAL_ARM_FREE_SWING_H
#define SIM_HAL_ARM_FREE_SWING_H

#include <optional>
#include <string>

#include "coupled_mode.h"

namespace berth
{

/* The damping ratio is that of a mode whose peaks shrink as these do. */
struct swing {
    double frequency_Hz;
    double damping_ratio;
};

/* What came to its limit, which small motions know nothing of. */
struct limits_met {
    bool joints[ARM_JOINTS_MAX] = {}; /* the servo's torque */
    bool wheel = false;               /* its torque */
    bool wheel_momentum = false;
};

struct free_swing {
    std::optional<double> frequency_Hz;  /* nothing: it could not be followed over two swings */
    std::optional<double> damping_ratio; /* nothing as well: the swings do not shrink as those of one mode */
    std::string not_measured;            /* in words, why something is missing */
    limits_met limits;
};

/* The arm starts in the shape of `mode`, its tool at a turning point `amplitude_m` from rest, once on either side;
 * the mean of both over two swings each, from turning point to turning point: what one side makes faster and the
 * other slower is no change of the swing. Commands stand still; the attitude's wheel works all the time, with its
 * limits, thrusters do not. */
free_swing swing_from(const arm_config &config, const reduction_choice &choice, const std::vector<beam_mode> &object,
                      const coupled_mode &mode, double amplitude_m);

} // namespace berth

#endif
