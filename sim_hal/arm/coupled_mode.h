/* Small motions of a whole arm with an object at its tool: the modes that the tool shows. */
#ifndef SIM_HAL_ARM_COUPLED_MODE_H
#define SIM_HAL_ARM_COUPLED_MODE_H

#include "linear_arm.h"

namespace berth
{

struct coupled_mode {
    std::complex<double> s;
    double share;           /* of the tool's mobility along the direction, the object fixed to it */
    Eigen::VectorXcd shape; /* q of the whole arm and, after it, of the object's further modes; 1 m of the tool */

    double frequency_Hz() const;
};

/* Those that swing and have a share of the tool's mobility that is worth while: by the others the tool does not
 * move. By rising size. */
std::vector<coupled_mode> visible_modes(const arm_config &config, const reduction_choice &choice,
                                        const std::vector<beam_mode> &object);

/* The nearest, by its ratio, to a frequency; nullptr where all are too far away to be the same swing. */
const coupled_mode *nearest_mode(const std::vector<coupled_mode> &modes, double frequency_Hz);

/* In words that there is none, and what there is. */
std::string none_is_near(const std::vector<coupled_mode> &modes, double frequency_Hz);

} // namespace berth

#endif
