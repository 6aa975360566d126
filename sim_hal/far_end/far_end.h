/* The simulated rig at the other end of real buses, in real time: robot, object, sensor and operator of a rig file,
 * for a loop that runs in another process over the kernel's CAN stack.
 *
 * Its periods lie where the loop's ticks lie, at whole multiples of the period of CLOCK_MONOTONIC. A little before
 * each it moves on to that instant and sends what has arrived there by then; force frames that are due earlier leave
 * when they are. A setpoint counts from the kernel's receive stamp, so a tick that sends late is passed late, as in
 * the simulation. */
#ifndef SIM_HAL_FAR_END_FAR_END_H
#define SIM_HAL_FAR_END_FAR_END_H

#include <atomic>
#include <string>

#include "../../hal/linux/can_socket.h"
#include "../hil/virtual_rig.h"

namespace berth
{

struct far_end_options {
    std::string robot_interface;
    std::string sensor_interface;
    bool waits_for_loop = true; /* time starts with the first frame of a loop; else at once */
    std::int64_t lead_us = 400; /* how long before a tick its frames are sent */
    std::int64_t priority = 70; /* SCHED_FIFO; 0: as it is */
};

struct far_end_result {
    std::int64_t periods = 0;
    std::int64_t late_periods = 0; /* whose frames left after the tick that they belong to */
    std::uint64_t setpoints = 0;
    can_counts robot_bus;
    can_counts sensor_bus;
};

class far_end
{
  public:
    /* Throws hardware_error. */
    far_end(const rig &rig, const far_end_options &options);

    /* Until `stop`, or until the loop says that it has stopped, or says nothing any more. */
    far_end_result run(const std::atomic<bool> &stop);

  private:
    bool wait_for_loop(const std::atomic<bool> &stop);
    void receive();
    void send(hal_bus bus, std::int64_t now_ns);
    void send_forces_until(std::int64_t time_ns);

    virtual_rig rig_;
    far_end_options options_;
    can_socket robot_bus_;
    can_socket sensor_bus_;
    stamp_clock stamps_;
    std::int64_t period_ns_;
    std::uint32_t setpoint_id_;
    std::int64_t zero_ns_ = 0;  /* the rig's time 0 by CLOCK_MONOTONIC */
    std::int64_t heard_ns_ = 0; /* the loop's newest frame */
    bool loop_has_stopped_ = false;
    far_end_result result_;
};

} // namespace berth

#endif
