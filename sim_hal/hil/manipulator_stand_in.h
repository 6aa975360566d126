/* A manipulator with effects. The firmware computes the manipulator, and knows none: where a rig has some, a
 * simulated run puts what such a manipulator does in the place of what the firmware has computed, tick by tick. */
#ifndef SIM_HAL_HIL_MANIPULATOR_STAND_IN_H
#define SIM_HAL_HIL_MANIPULATOR_STAND_IN_H

#include "../../firmware/app.h"
#include "../solver/manipulator_steps.h"

namespace berth
{

class manipulator_stand_in
{
  public:
    explicit manipulator_stand_in(const rig &rig) : steps_(rig, config_period_s(&rig.firmware)) {}

    /* After each tick of the loop. */
    void replace(app &app);

  private:
    manipulator_steps steps_;
    bool was_running_ = false;
};

} // namespace berth

#endif
