/* The step in which positions travel on the robot's bus, by the profile of the robot channel. */
#ifndef SIM_HAL_HIL_SETPOINT_STEP_H
#define SIM_HAL_HIL_SETPOINT_STEP_H

#include "../../firmware/can/berth_can.h"
#include "../../firmware/config.h"

namespace berth
{

inline double setpoint_step_m(const app_config &firmware)
{
    return firmware.robot_channel.profile == ROBOT_PROFILE_CIA402 ? 1.0 / firmware.cia402.counts_per_m
                                                                  : berth_can_setpoint_position_m_decode(1);
}

} // namespace berth

#endif
