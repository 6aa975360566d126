/* Everything behind the wires, in virtual time: buses, robot, object, sensor, operator. It only moves when it is
 * told to, so the firmware on the other side never waits for a clock, and a seed repeats a run bit for bit.
 *
 * Order at one instant: the reference changes first, then the force is sampled, then the robot reports, then the
 * operator sends. So a sample at the instant of a setpoint knows of it. Where the robot does not know yet how to go
 * on after a setpoint, it stops last of all: a sample at that instant sees it moving. */
#ifndef SIM_HAL_HIL_VIRTUAL_RIG_H
#define SIM_HAL_HIL_VIRTUAL_RIG_H

#include "../plant/plant.h"
#include "../solver/solver.h"
#include "can_bus.h"
#include "operator_station.h"
#include "robot.h"
#include "sensor.h"

namespace berth
{

/* What is really so, at one instant; the loop only knows what the frames say. */
struct rig_truth {
    double robot_position_m;
    double robot_velocity_m_per_s;
    double object_position_m;
    double object_velocity_m_per_s;
    double spring_force_N;   /* before the low-pass */
    double measured_force_N; /* after it, before the sensor's electronics */
};

class virtual_rig
{
  public:
    explicit virtual_rig(const rig &rig);

    /* Lets everything happen up to and including `now_ns`. Time never runs backwards. */
    void advance_to(std::int64_t now_ns);

    std::int64_t now_ns() const { return now_ns_; }

    can_bus &bus(hal_bus bus) { return buses_[bus]; }

    /* A frame from the loop, sent at `frame.time_ns`. */
    void receive_from_loop(const hal_frame &frame);

    rig_truth truth() const;
    const plant_state &state() const { return state_; }
    const plant &equations() const { return plant_; }

    /* For tests: as advance_to(), but what happens at `now_ns` itself is still to come. */
    void approach(std::int64_t now_ns);

    /* For tests: puts the plant into another state, here and now. */
    void set_state(const plant_state &state) { state_ = state; }

    /* For tests and demonstrations: pull a plug, push a button. */
    void set_robot_silent(bool silent) { robot_is_silent_ = silent; }
    void set_robot_fault(bool fault) { robot_has_fault_ = fault; }
    sensor &force_sensor() { return sensor_; }
    operator_station &operators() { return operator_station_; }

  private:
    void integrate_to(std::int64_t time_ns);
    void move_reference();
    void report_robot_position();

    plant plant_;
    std::unique_ptr<solver> solver_;
    plant_state state_;
    can_bus buses_[HAL_BUS_COUNT];
    robot robot_;
    sensor sensor_;
    operator_station operator_station_;
    std::int64_t period_ns_;
    std::int64_t now_ns_ = 0;
    std::int64_t next_report_ns_ = 0;
    std::uint8_t report_counter_ = 0;
    bool robot_is_silent_ = false;
    bool robot_has_fault_ = false;
};

} // namespace berth

#endif
