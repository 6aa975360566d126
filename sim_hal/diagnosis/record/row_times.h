/* Whether rows with uneven stamps were taken at their stamps, or evenly and stamped late: a motion is smooth over
 * the times at which it was measured, and rough over others. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_ROW_TIMES_H
#define SIM_HAL_DIAGNOSIS_RECORD_ROW_TIMES_H

#include <vector>

namespace berth
{

/* `stamp_s` and `due_s`, both increasing: when each row says that it was taken, and when it was due on an even grid.
 * `smooth`: a measured motion. True if each value follows far better from its neighbours over the stamps. */
bool are_taken_at_stamps(const std::vector<double> &stamp_s, const std::vector<double> &due_s,
                         const std::vector<double> &smooth);

/* Values at the times that were due, along cubics through the four nearest rows. */
std::vector<double> at_due_times(const std::vector<double> &stamp_s, const std::vector<double> &due_s,
                                 const std::vector<double> &values);

} // namespace berth

#endif
