/* Records beside the one that is diagnosed: a standstill, a repetition, one to validate with. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_SIDE_RECORDS_H
#define SIM_HAL_DIAGNOSIS_RECORD_SIDE_RECORDS_H

#include <optional>
#include <string>

#include "../noise/noise.h"
#include "../replay/block_model.h"
#include "record.h"

namespace berth
{

/* Noise of a channel while nothing moves: about a straight line. Nothing where the record says nothing of it. */
std::optional<noise_model> standstill_floor(const record &record, block block);

/* Whether what moves the block, and what shows it, is told in both. */
bool have_same_columns(const record &first, const record &second, block block);

/* All that moves what the block's output shows is the same in both. */
bool go_the_same_way(const record &first, const record &second, block block);

/* Half the variance of the difference of two runs. Where the force's noise has moved the command, the two do not go
 * the same way: of what each measures less what the rig makes of it. Nothing where there is no telling. */
std::optional<noise_model> repetition_floor(const record &first, const record &second, block block, const rig &rig);

/* A record that could not serve at all in its role, --validate, --standstill or --repeat. Throws input_error. */
void refuse_useless(const record &other, const std::string &role, const record &data);

} // namespace berth

#endif
