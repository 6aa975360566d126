/* A manipulator with effects. The firmware computes the manipulator, and knows none: where a rig has some, a
 * simulated run puts what such a manipulator does in the place of what the firmware has computed, tick by tick. */
#ifndef SIM_HAL_HIL_MANIPULATOR_STAND_IN_H
#define SIM_HAL_HIL_MANIPULATOR_STAND_IN_H

#include "../../firmware/app.h"
#include "../../firmware/loop.h"
#include "../solver/manipulator_steps.h"

namespace berth
{

class manipulator_stand_in
{
  public:
    explicit manipulator_stand_in(const rig &rig) : steps_(rig, config_period_s(&rig.firmware)) {}

    /* After each tick of the loop. */
    void replace(app &app);

    /* A tick of the loop, and then that. False: the hardware is gone. */
    bool tick(struct hal *hal, app &app)
    {
        const bool goes_on = loop_tick(hal, &app) == HAL_OK;
        if (goes_on) {
            replace(app);
        }
        return goes_on;
    }

  private:
    manipulator_steps steps_;
    bool was_running_ = false;
};

} // namespace berth

#endif
