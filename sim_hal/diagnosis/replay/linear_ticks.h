/* The linear object over whole ticks: the steps of a tick made one map, so that a replay takes each tick at once. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_LINEAR_TICKS_H
#define SIM_HAL_DIAGNOSIS_REPLAY_LINEAR_TICKS_H

#include <array>
#include <vector>

#include "../../solver/object_steps.h"
#include "replay.h"

namespace berth
{

class linear_ticks
{
  public:
    using state = object_steps::body_state;

    /* `maps`: of each kind of step of the tick, for an object that holds. The force is the low-pass's output. */
    linear_ticks(const tick_steps &tick, const std::vector<object_steps::step_maps> &maps);

    /* Goes on by one tick, the robot passing `position_m`: at its begin and at the end of every step, with the
     * corners of `bulge_m` within each step (see robot_way) where it is not null. The force when it is sampled, N.
     */
    double advance(state &of, const double *position_m, const double *bulge_m) const;

  private:
    bool samples_within_; /* else at the begin */
    std::vector<state> of_position_;
    std::vector<state> of_bulge_;
    std::array<state, object_steps::rows> of_state_{};
    std::vector<double> sample_; /* of (state, positions, bulges) */
};

} // namespace berth

#endif
