/* Where the delay of a slow force comes from: from the command over robot, object and sensor back into the loop. */
#ifndef SIM_HAL_DELAY_BUDGET_H
#define SIM_HAL_DELAY_BUDGET_H

#include <string_view>
#include <vector>

#include "../hal/rig/rig.h"

namespace berth
{

struct delay_part {
    std::string_view name; /* in words */
    std::string_view key;  /* in JSON, unit included */
    double delay_ms;       /* less than 0: the inverse filter makes up for some of the robot's lag */
};

/* The parts add up to loop_delay_s(): a tick's force is held for a period, half of one in the mean. An arm
 * may lead it by as much. */
struct delay_budget {
    double robot_ms = 0.0;    /* dead time without its frames on the bus, lags, inverse filter */
    double hold_ms = 0.0;     /* half a period that the force is held, unless an arm leads it; as much for a robot
                                 that jumps and holds */
    double bus_ms = 0.0;      /* frames of setpoint and force sample */
    double sensor_ms = 0.0;   /* sample to arrival without its frames on the bus, and lag */
    double low_pass_ms = 0.0; /* of the force */
    double wait_ms = 0.0;     /* of an arrived sample, and of a CiA 402 setpoint, for the next tick */

    double total_ms() const { return robot_ms + hold_ms + bus_ms + sensor_ms + low_pass_ms + wait_ms; }

    /* In the order of the signal. */
    std::vector<delay_part> parts() const;
};

/* Of a rig that has been checked; of one that schedules a change, as it is at the start. */
delay_budget delay_budget_of(const rig &rig);

/* What a schedule makes of the loop's delay from a time on, on the clock of the run. */
struct scheduled_delay {
    double from_s;
    double total_ms;
};

/* Where a jump or a drift changes it, in order of time; empty: it stays. */
std::vector<scheduled_delay> delays_of_schedule(const rig &rig);

} // namespace berth

#endif
