/* What happens behind the wires at single instants: setpoints taken and passed, samples, reports, operator commands,
 * frames on their way. What happens in between is the hardware's, which is handed in: the plant in a simulated rig.
 *
 * Order at one instant: the reference changes first, then the force is sampled, then the robot reports, then the
 * operator sends. So a sample at the instant of a setpoint knows of it. Where the robot does not know yet how to go
 * on after a setpoint, it stops last of all: a sample at that instant sees it moving. */
#ifndef SIM_HAL_HIL_RIG_EVENTS_H
#define SIM_HAL_HIL_RIG_EVENTS_H

#include <algorithm>
#include <memory>

#include "can_bus.h"
#include "cia402_drive.h"
#include "operator_station.h"
#include "robot.h"
#include "sensor.h"
#include "side_hardware.h"

namespace berth
{

class rig_events
{
  public:
    explicit rig_events(const rig &rig);
    rig_events(const rig_events &) = delete; /* the drive knows robot and bus */
    rig_events &operator=(const rig_events &) = delete;

    /* Lets everything happen up to and including `now_ns`. Time never runs backwards. `hardware` has
     *   void travel(const robot &, std::int64_t now_ns, std::int64_t duration_ns)   no event for so long
     *   void jump(const robot &, double jump_m)                                     the reference has jumped
     *   double measured_force_N(const robot &, std::int64_t now_ns)
     *   double robot_position_m(const robot &, std::int64_t now_ns) */
    template <typename hardware_side>
    void advance_to(std::int64_t now_ns, hardware_side &hardware)
    {
        for (;;) {
            const std::int64_t next_ns = std::min({robot_.next_event_ns(), sensor_.next_sample_ns(), next_report_ns_,
                                                   operator_station_.next_frame_ns(), drive_event_ns()});
            if (next_ns > now_ns) {
                break;
            }
            travel_to(next_ns, hardware);
            if (robot_.next_event_ns() == next_ns && !robot_.stops_next()) {
                move_reference(hardware);
            } else if (sensor_.next_sample_ns() == next_ns) {
                sample_force(hardware.measured_force_N(robot_, now_ns_));
            } else if (next_report_ns_ == next_ns) {
                report_robot_position(hardware.robot_position_m(robot_, now_ns_));
            } else if (operator_station_.next_frame_ns() == next_ns) {
                operator_station_.send(buses_[operator_station_.bus()]);
            } else if (drive_event_ns() == next_ns) {
                drive_->handle_event();
            } else { /* the robot stops, unless the loop is about to send where to go on */
                if (next_ns == now_ns) {
                    break;
                }
                move_reference(hardware);
            }
        }
        travel_to(now_ns, hardware);
    }

    /* As advance_to(), but what happens at `now_ns` itself is still to come. */
    template <typename hardware_side>
    void approach(std::int64_t now_ns, hardware_side &hardware)
    {
        advance_to(now_ns - 1, hardware);
        travel_to(now_ns, hardware);
    }

    std::int64_t now_ns() const { return now_ns_; }
    can_bus &bus(hal_bus bus) { return buses_[bus]; }
    const berth::robot &robot() const { return robot_; }

    /* A frame from the loop, sent at `frame.time_ns`. */
    void receive_from_loop(const hal_frame &frame);

    void set_robot_silent(bool silent);
    void set_robot_fault(bool fault);
    cia402_drive *drive() { return drive_.get(); } /* nullptr: another profile */
    sensor &force_sensor() { return sensor_; }
    operator_station &operators() { return operator_station_; }

  private:
    template <typename hardware_side>
    void travel_to(std::int64_t time_ns, hardware_side &hardware)
    {
        if (time_ns > now_ns_) {
            hardware.travel(robot_, now_ns_, time_ns - now_ns_);
            now_ns_ = time_ns;
        }
    }

    template <typename hardware_side>
    void move_reference(hardware_side &hardware)
    {
        const double jump_m = robot_.handle_event();
        if (jump_m != 0.0) {
            hardware.jump(robot_, jump_m);
        }
    }

    void sample_force(double force_N);
    void report_robot_position(double position_m);
    void send_feedback(std::uint32_t id, double position, std::uint8_t setpoint_counter, std::uint8_t counter);
    std::int64_t drive_event_ns() const { return drive_ ? drive_->next_event_ns() : canopen_node::never_ns; }
    bool is_tick_lost(std::int64_t tick);

    can_bus buses_[HAL_BUS_COUNT];
    berth::robot robot_;
    std::unique_ptr<cia402_drive> drive_; /* profile "cia402" */
    std::vector<std::unique_ptr<side_hardware>>
        sides_; /* of the robot's further axes; it lags behind until it is asked */
    sensor sensor_;
    operator_station operator_station_;
    std::int64_t period_ns_;
    std::int64_t now_ns_ = 0;
    std::int64_t next_report_ns_ = 0; /* a drive's: as SYNC asks for it */
    std::uint8_t report_counter_ = 0;
    random_stream feedback_;
    double feedback_noise_m_;
    random_stream lost_;
    std::int64_t ticks_kept_; /* more than a sample takes to arrive */
    double lost_probability_;
    std::vector<std::uint8_t> tick_is_lost_; /* from first_known_tick_ on */
    std::int64_t first_known_tick_ = 0;
    bool robot_is_silent_ = false;
    bool robot_has_fault_ = false;
};

} // namespace berth

#endif
