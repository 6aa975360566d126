/* Noise that follows the motion: a dead time that jitters, a gain that wanders. No replay is wrong on average then,
 * and no effect explains it. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_UNEVEN_NOISE_H
#define SIM_HAL_DIAGNOSIS_NOISE_UNEVEN_NOISE_H

#include <string>
#include <vector>

#include "../search/block_diagnosis.h"

namespace berth
{

/* A line for each block whose error grows with the velocity or the size of what it ought to be: by how much a delay
 * or a gain would have to vary for that. None where more than noise is left. */
std::vector<std::string> noise_that_follows_motion(const std::vector<block_diagnosis> &blocks, const record &data);

} // namespace berth

#endif
