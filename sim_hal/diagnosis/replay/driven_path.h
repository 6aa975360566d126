/* Where a robot goes by its setpoints, those lost among them: at the ticks at which it ought to be there. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_DRIVEN_PATH_H
#define SIM_HAL_DIAGNOSIS_REPLAY_DRIVEN_PATH_H

#include <cstdint>
#include <optional>
#include <vector>

#include "../../effects/setpoint_path.h"
#include "../../effects/velocity_follower.h"
#include "../record/record.h"

namespace berth
{

/* What a rig has in the way of its setpoints that depends on those before: limits of the drive, a dead band, play in
 * the gears where nothing is between it and the reference. */
class driven_path
{
  public:
    /* At the first setpoint of a record. */
    driven_path(const rig &rig, const record &record);

    /* Return where it is when it ought to be on the next setpoint, or on the one that was lost. */
    double take(double setpoint_m) { return play_behind(follow(path_.take(setpoint_m))); }
    double go_on() { return play_behind(follow(path_.go_on())); }

  private:
    double follow(double reference_m);
    double play_behind(double driven_m);

    setpoint_path path_;
    std::optional<velocity_follower> follower_;
    double period_s_;
    bool holds_;
    double reference_m_;
    double half_gap_m_; /* 0: no play */
    double held_m_;
};

/* Nothing of that: a setpoint takes the robot where it leads whatever came before it. */
bool follows_setpoints(const rig &rig);
rig that_follows_setpoints(rig made);

/* Of each setpoint, for all losses up to it. */
std::vector<double> way_lacked_m(const rig &rig, const record &record, const std::vector<std::uint8_t> &lost);

/* Of each setpoint, what the robot would lack if it was lost, after those before it. */
std::vector<double> way_at_stake_m(const rig &rig, const record &record, const std::vector<std::uint8_t> &lost);

} // namespace berth

#endif
