/* What the robot makes of the setpoints that reach it: effects on setpoints, then the limits that are on these. */
#ifndef SIM_HAL_EFFECTS_SETPOINT_PATH_H
#define SIM_HAL_EFFECTS_SETPOINT_PATH_H

#include <memory>
#include <optional>
#include <vector>

#include "drive_limits.h"
#include "stages.h"

namespace berth
{

struct rig;

class setpoint_path
{
  public:
    explicit setpoint_path(const rig &rig);
    setpoint_path(const setpoint_path &other);
    setpoint_path &operator=(const setpoint_path &other);
    setpoint_path(setpoint_path &&) = default;
    setpoint_path &operator=(setpoint_path &&) = default;
    ~setpoint_path() = default;

    /* At rest on a setpoint: returns where the robot stands. */
    double start(double setpoint_m);

    /* Returns where the robot goes. */
    double take(double setpoint_m);

    /* The same in a period in which no setpoint comes: a drive with limits goes on towards the one that it has. */
    double go_on();
    bool goes_on() const { return limits_.has_value(); }

    /* It goes to each setpoint. */
    bool is_plain() const { return stages_.empty() && !limits_; }

  private:
    std::vector<std::unique_ptr<setpoint_stage>> stages_;
    std::optional<drive_limits> limits_;
    double position_m_ = 0.0;
};

} // namespace berth

#endif
