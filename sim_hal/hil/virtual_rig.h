/* Everything behind the wires, in virtual time: buses, robot, object, sensor, operator. It only moves when it is
 * told to, so the firmware on the other side never waits for a clock, and a seed repeats a run bit for bit. */
#ifndef SIM_HAL_HIL_VIRTUAL_RIG_H
#define SIM_HAL_HIL_VIRTUAL_RIG_H

#include "../solver/effect_solver.h"
#include "../solver/gripped_plant.h"
#include "rig_events.h"

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
    void advance_to(std::int64_t now_ns) { events_.advance_to(now_ns, hardware_); }

    std::int64_t now_ns() const { return events_.now_ns(); }

    can_bus &bus(hal_bus bus) { return events_.bus(bus); }

    /* A frame from the loop, sent at `frame.time_ns`. */
    void receive_from_loop(const hal_frame &frame) { events_.receive_from_loop(frame); }

    rig_truth truth() const;
    beam_state state() const { return hardware_.effects ? hardware_.effects->state() : hardware_.base.state(); }
    const plant &equations() const { return hardware_.base.equations(); }

    /* For tests: as advance_to(), but what happens at `now_ns` itself is still to come. */
    void approach(std::int64_t now_ns) { events_.approach(now_ns, hardware_); }

    /* For tests: puts the plant into another state, here and now. */
    void set_state(const beam_state &state);

    /* For tests and demonstrations: pull a plug, push a button. */
    void set_robot_silent(bool silent) { events_.set_robot_silent(silent); }
    void set_robot_fault(bool fault) { events_.set_robot_fault(fault); }
    sensor &force_sensor() { return events_.force_sensor(); }
    operator_station &operators() { return events_.operators(); }

  private:
    /* The plant, integrated between the events: the base model, or with effects in it. */
    struct hardware {
        gripped_plant base;
        std::unique_ptr<effect_solver> effects; /* nullptr: none between reference and sample */

        void travel(const robot &robot, std::int64_t now_ns, std::int64_t duration_ns)
        {
            if (effects) {
                return effects->advance(robot.line(now_ns), duration_ns);
            }
            base.advance(robot.line(now_ns), now_ns, duration_ns);
        }
        void jump(const robot &robot, double jump_m)
        {
            if (effects) {
                return effects->jump(robot.course_now().from_m);
            }
            base.jump(jump_m);
        }
        double measured_force_N(const robot &robot, std::int64_t now_ns) const
        {
            return effects ? effects->measured_force_N() : base.measured_force_N(robot.line(now_ns));
        }
        double robot_position_m(const robot &robot, std::int64_t now_ns) const
        {
            return effects ? effects->robot_position_m() : base.robot_position_m(robot.line(now_ns));
        }
    };

    rig_events events_;
    hardware hardware_;
};

} // namespace berth

#endif
