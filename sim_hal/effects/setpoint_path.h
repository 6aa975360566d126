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

    /* At rest on a setpoint: returns where the robot stands. */
    double start(double setpoint_m);

    /* Returns where the robot goes. */
    double take(double setpoint_m);

    /* It goes to each setpoint. */
    bool is_plain() const { return stages_.empty() && !limits_; }

  private:
    std::vector<std::unique_ptr<setpoint_stage>> stages_;
    std::optional<drive_limits> limits_;
};

} // namespace berth

#endif
