/* Rows that a logger lost, a few in a row: the loop went on meanwhile, and so does the replay. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_RECORD_GAPS_H
#define SIM_HAL_DIAGNOSIS_RECORD_RECORD_GAPS_H

#include <optional>
#include <vector>

#include "record.h"

namespace berth
{

/* Before row `before` so many are missing. */
struct missing_rows {
    std::size_t before;
    std::size_t count;
};

/* How many rows a step in time leaves out, if they are so few that the command between can be told: else nothing. */
std::optional<std::size_t> rows_left_out(double step_s, double period_s);

/* Of a segment, what lies between rows that are missing. */
std::vector<record_segment> known_stretches(const record &record, const record_segment &segment);

/* Puts the rows back: every signal as the rows about it tell, and marked in `filled`. */
void fill_in(record &made, const std::vector<missing_rows> &missing);

} // namespace berth

#endif
