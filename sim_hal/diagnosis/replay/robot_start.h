/* Where the robot is as a part of a record begins. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_ROBOT_START_H
#define SIM_HAL_DIAGNOSIS_REPLAY_ROBOT_START_H

#include "../record/record.h"

namespace berth
{

/* Marks the parts that begin with a robot that stands elsewhere than its setpoint says, and then goes there: a step
 * in the first row, as step responses are recorded. A replay that began on the setpoint would miss the step. */
void find_starts_elsewhere(record &made);

/* Whether a part begins with a robot that stands where it was told to, or elsewhere, see above, and nothing of what
 * was told before moves it, in the time that this is `on_the_way_s`. Near a turning point the setpoint hardly moves,
 * and the robot still comes from where it was. */
class robot_at_rest
{
  public:
    robot_at_rest(const record &record, double on_the_way_s);
    bool begins(const record_segment &part) const;

  private:
    const record &record_;
    double on_the_way_s_;
    double range_m_;    /* of the setpoint */
    double standing_m_; /* rms: what noise, as fast as it is, and rounding move it */
};

/* Where the robot was seen to stand, in m, on average until what drives it, at goal_m[n] in the part's row n, takes
 * it along: behind a gap of `gap_m` to either side it may begin anywhere. goal_m[0] where that is no clearly other
 * place, or its position was not recorded. */
double seen_before_it_moves_m(const record &record, const record_segment &part, const std::vector<double> &goal_m,
                              double gap_m);

} // namespace berth

#endif
