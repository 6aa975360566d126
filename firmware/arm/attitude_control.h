/* Holds the base's attitude: a reaction wheel with a PD law, or thrusters that fire pulses of the least length that
 * they can, the disturbance that an arm on a satellite has to live with: each time that the law is due and no pulse
 * lasts, it may ask for one more. Every axis by itself. */
#ifndef FIRMWARE_ARM_ATTITUDE_CONTROL_H
#define FIRMWARE_ARM_ATTITUDE_CONTROL_H

#include "chain.h"

namespace berth
{

template <class Space>
struct attitude_control {
    typename Space::attitude wanted;
    int32_t ticks_to_next;  /* until the law is evaluated again */
    int32_t pulse_sign[3];  /* thrusters: -1, 0, 1 */
    int32_t pulse_ticks[3]; /* that the pulse has yet to last */
    typename Space::angular wheel_wanted_N_m; /* of the law, held until it is evaluated again */
    typename Space::angular wheel_torque_N_m; /* of that, what the wheel has room for */
    typename Space::angular thruster_torque_N_m;
};

/* `start`: whose attitude is to be held. */
template <class Space>
attitude_control<Space> attitude_control_at(const chain_state<Space> &start);

/* Once a tick, with the state at its begin: what acts until the next. */
template <class Space>
void attitude_control_step(attitude_control<Space> &control, const attitude_config &config, double period_s,
                           const chain_state<Space> &state);

} // namespace berth

#endif
