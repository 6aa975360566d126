/* What pushes a measured manipulator between the rows of a record: held, as a digital control leaves it, or moving
 * on, as a sampled sensor saw it. Half a row's lateness is the difference, and would be told as damping. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_MOVING_PUSH_H
#define SIM_HAL_DIAGNOSIS_REPLAY_MOVING_PUSH_H

#include <functional>
#include <optional>
#include <string>

#include "../search/block_diagnosis.h"

namespace berth
{

/* With the records as they are. */
struct manipulator_work {
    std::function<block_diagnosis()> diagnose;
    std::function<double(const block_diagnosis &found)> refit; /* white sum of squares that what was found leaves */
};

/* `held`: what was found with the push held. Where the push changes enough from row to row for it to matter, or the
 * refit of what stays open shows that it does, the diagnosis is made again with one that moves; the better of both
 * is returned, and the records are left as it has them. A line in `notes` says which it is, or that it stays open.
 */
block_diagnosis better_of_held_and_moving(block_diagnosis held, record &data, std::optional<record> &validation,
                                          const manipulator_work &again, std::vector<std::string> &notes);

} // namespace berth

#endif
