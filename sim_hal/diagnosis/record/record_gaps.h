/* Rows that a logger lost, a few in a row: the loop went on meanwhile, and so does the replay. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_RECORD_GAPS_H
#define SIM_HAL_DIAGNOSIS_RECORD_RECORD_GAPS_H

#include <cstdint>
#include <vector>

#include "record.h"

namespace berth
{

/* Before row `before` so many are missing. */
struct missing_rows {
    std::size_t before;
    std::size_t count;
};

/* So few that the command between can be told: of one at 400 Hz, a polynomial over these rows misses a 3 Hz motion
 * by far less than 2e-5 of it. */
inline constexpr std::int64_t missing_rows_max = 4;

/* Of a segment, what lies between rows that are missing. */
std::vector<record_segment> known_stretches(const record &record, const record_segment &segment);

/* Puts the rows back: every signal as the rows about it tell, and marked in `filled`. `place`: of each row that is
 * there, among evenly spaced ones of its part. */
void fill_in(record &made, const std::vector<missing_rows> &missing, const std::vector<double> &place);

} // namespace berth

#endif
