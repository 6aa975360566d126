/* Whether a robot is late by another time in some stretches of the record than in others. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_DELAY_STRETCHES_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_DELAY_STRETCHES_H

#include "../noise/noise.h"
#include "../replay/block_model.h"

namespace berth
{

struct delay_stretches {
    double squares = 0.0; /* of the white error that a delay of its own in each stretch explains */
    double count = 0.0;   /* of stretches: what noise alone would explain */

    double beyond_noise() const { return squares - count; }
    bool are_clear() const;
};

/* Of the robot's block; `error`: of the model's last rig. */
delay_stretches find_delay_stretches(const block_model &robot, const noise_model &noise,
                                     const std::vector<double> &error);

} // namespace berth

#endif
