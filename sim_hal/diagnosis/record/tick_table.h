/* The ticks of a log as a CSV file, as `berth export --csv` and ulog2csv write them. Such a file is read as its log
 * is: the rows in which the loop ran, each with where the robot was when the tick began, which the next one reports.
 */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_TICK_TABLE_H
#define SIM_HAL_DIAGNOSIS_RECORD_TICK_TABLE_H

#include <array>
#include <string>

#include "record.h"
#include "record_table.h"

namespace berth
{

/* What the ticks of a log have beside a record's signals. */
inline constexpr std::array tick_columns = {"scheduled_ns", "state", "limits"};

/* Not where the rig file has a column of its own for a signal. */
bool is_table_of_ticks(const record_table &table, const rig &rig);

/* `rig` counts as that of the loop. Throws input_error as record_of_ticks does. */
record record_of_table(const record_table &table, const std::string &path, const rig &rig, bool may_be_still);

} // namespace berth

#endif
