/* The linear object over whole ticks: the steps of a tick made one map, so that a replay takes each tick at once. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_LINEAR_TICKS_H
#define SIM_HAL_DIAGNOSIS_REPLAY_LINEAR_TICKS_H

#include <array>
#include <vector>

#include "../../solver/object_steps.h"
#include "replay.h"

namespace berth
{

/* `kept`: of the object's further force, if it has one: linear_law::kept, else 0. */
template <std::size_t kept>
class linear_ticks
{
  public:
    static constexpr std::size_t rows = object_steps::rows + kept;
    using state = std::array<double, rows>; /* of the object, then what its further force keeps */

    /* Of one that was started. `maps`: of each kind of step of the tick, for an object that holds. The force is the
     * low-pass's output. */
    linear_ticks(const object_steps &object, const tick_steps &tick,
                 const std::vector<object_steps::step_maps> &maps);

    /* Of an object that was started. */
    static state at_rest(const object_steps &object);

    /* Goes on by one tick, the robot passing `position_m`: at its begin and at the end of every step, with the
     * corners of `bulge_m` within each step (see robot_way) where it is not null. The force when it is sampled, N.
     */
    double advance(state &of, const double *position_m, const double *bulge_m) const;

  private:
    bool samples_within_; /* else at the begin */
    std::vector<state> of_position_;
    std::vector<state> of_bulge_;
    std::array<state, rows> of_state_{};
    std::vector<double> sample_; /* of (state, positions, bulges) */
};

extern template class linear_ticks<0>;
extern template class linear_ticks<linear_law::kept>;

} // namespace berth

#endif
