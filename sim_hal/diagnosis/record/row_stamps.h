/* Which place on the loop's even grid of ticks each row of a record has, by its stamp. A stamp may be late, as where
 * a logger was not woken in time, while the loop went on; a place without a row is a row that is missing. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_ROW_STAMPS_H
#define SIM_HAL_DIAGNOSIS_RECORD_ROW_STAMPS_H

#include <cstddef>
#include <cstdint>
#include <vector>

namespace berth
{

/* Rows [begin, end) whose stamps increase, of one part of a record. */
struct stamped_part {
    std::size_t begin;
    std::size_t end;
};

/* Places of a part's rows, from 0 on, increasing: each stamp's nearest on the grid, except that a late row goes
 * before its successor. */
std::vector<std::int64_t> places_on_grid(const std::vector<double> &time_s, stamped_part part, double period_s);

struct row_clock {
    double line_s;        /* slope of the line through the stamps of all parts, over their places */
    double median_step_s; /* of the steps between neighbouring stamps */
    bool has_usual_step;  /* of a logger whose delays add up: most steps are the median, some far longer */
};

/* `median_step_s` > 0: of the steps that are no gap. */
row_clock clock_of(const std::vector<double> &time_s, const std::vector<stamped_part> &parts, double median_step_s);

/* Of stamps against their places: most of those about a row are on time. */
struct lateness {
    std::size_t late; /* rows by more than a quarter of a period */
    double largest_s; /* of those */
    double jitter_s;  /* largest of the others, to either side */
};
lateness lateness_of(const std::vector<double> &time_s, stamped_part part, const std::vector<std::int64_t> &places,
                     double period_s);

} // namespace berth

#endif
