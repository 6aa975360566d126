/* What drives the manipulator, written with fewer digits than the loop had. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_WRITTEN_DIGITS_H
#define SIM_HAL_DIAGNOSIS_RECORD_WRITTEN_DIGITS_H

#include <string>
#include <vector>

#include "../replay/block_model.h"

namespace berth
{

/* Of each value the unit of its last digit: so many behind the point, or so many in all. 0 where all digits are
 * there, or where a signal of few levels may be exact. */
std::vector<double> units_of_last_digits(const std::vector<double> &values);

/* rms, in m, of what such digits leave open of the manipulator's position: the largest of several roundings, as one
 * slow swing may come out by chance. 0: nothing, as in a log of this firmware. */
double rms_of_written_digits(block_model &manipulator, const rig &rig);

/* Which columns these are, and the largest unit of each. */
std::string columns_with_few_digits(const record &data);

} // namespace berth

#endif
