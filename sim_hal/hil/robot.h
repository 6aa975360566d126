/* The simulated robot's command side: setpoint frames in, reference line out. Its dead time is a queue of
 * setpoints ordered by the instant at which the robot passes through them. */
#ifndef SIM_HAL_HIL_ROBOT_H
#define SIM_HAL_HIL_ROBOT_H

#include <algorithm>
#include <cstdint>
#include <limits>
#include <vector>

#include "../../firmware/can/berth_can.h"
#include "../../hal/hal.h"
#include "../../hal/rig/rig.h"
#include "../effects/setpoint_path.h"
#include "../effects/velocity_follower.h"
#include "../plant/plant.h"
#include "random.h"

namespace berth
{

class robot
{
  public:
    /* `setpoint_id`: of the frames that it follows, all laid out as the setpoint in berth.dbc. */
    explicit robot(const rig &rig, std::uint32_t setpoint_id = BERTH_CAN_SETPOINT_FRAME_ID);

    /* Takes a setpoint frame that was sent at `frame.time_ns` and arrives at `arrival_ns`. */
    void receive(const hal_frame &frame, std::int64_t arrival_ns);

    /* A drive's setpoint acts at a SYNC that was sent at `now_ns`, and is reached over `interpolation_ns`. */
    void take_synchronous(double position_m, std::int64_t now_ns, std::int64_t interpolation_ns);

    /* Whether the command that has just come is lost inside of the robot. */
    bool loses_command() { return lost_.happens(lost_probability_); }

    /* When the reference next changes its course, or the robot's own clock next looks for a setpoint. */
    std::int64_t next_event_ns() const { return std::min(next_event_ns_, caught_up_ns_); }

    /* The next event is the end of a line after which the robot does not know yet where to go, as it is at every
     * setpoint with a dead time of one period. Whoever looks at that very instant still sees it move. */
    bool stops_next() const
    {
        const knot &goal = knots_[first_];
        return is_moving_ && next_event_ns() == goal.end_ns && next_event_ns() != next_latch_ns_ &&
               (count_ == 1 || knots_[(first_ + 1) % knots_.size()].begin_ns > goal.end_ns);
    }

    /* Does what is due at next_event_ns(). Returns the jump of the reference in m: 0 but for "hold". */
    double handle_event();

    /* The reference from `now_ns` on, until the next event. */
    reference_line line(std::int64_t now_ns) const
    {
        return limits_reference_ ? on_line(limited_line_, limited_from_ns_, now_ns)
                                 : on_line(line_, start_ns_, now_ns);
    }

    /* The line that the reference, before a limit of its velocity, is on or, where it rests, the place. */
    struct course {
        std::int64_t from_ns;
        std::int64_t to_ns; /* from_ns where it rests */
        double from_m;
        double to_m;
    };
    course course_now() const
    {
        if (!is_moving_) {
            return {start_ns_, start_ns_, line_.position_m, line_.position_m};
        }
        return {start_ns_, knots_[first_].end_ns, line_.position_m, knots_[first_].position_m};
    }

    std::uint8_t setpoint_counter() const { return setpoint_counter_; } /* of the newest setpoint taken */

  private:
    /* The robot sets out for position_m at begin_ns and is there at end_ns ("hold": jumps at end_ns). */
    struct knot {
        std::int64_t begin_ns;
        std::int64_t end_ns;
        double position_m;
    };
    struct setpoint {
        std::int64_t arrival_ns;
        double position_m;
        std::uint8_t counter;
    };

    static reference_line on_line(const reference_line &line, std::int64_t from_ns, std::int64_t now_ns)
    {
        return {line.position_m + line.velocity_m_per_s * (static_cast<double>(now_ns - from_ns) * 1e-9),
                line.velocity_m_per_s};
    }
    double handle_reference_event();
    void limit_velocity(std::int64_t now_ns);
    std::int64_t dead_time_ns(std::int64_t now_ns) const;
    void latch();
    void drop_overtaken(std::int64_t end_ns);
    void take(const setpoint &next, std::int64_t now_ns);
    void add_knot(double position_m, std::int64_t now_ns);
    void set_out();
    double arrive();
    void find_next_event();

    std::uint32_t setpoint_id_;
    bool holds_;
    bool clock_is_free_;
    std::int64_t dead_time_ns_;
    std::int64_t period_ns_; /* between setpoints, by the robot's clock or as a drive was told */
    double clock_period_ns_;
    double clock_phase_ns_;
    double jitter_ns_;
    std::int64_t jump_at_ns_;
    std::int64_t jumped_dead_time_ns_; /* from then on */
    double dead_time_drift_;           /* ns of dead time a ns of time */
    double lost_probability_;
    random_stream random_;
    random_stream lost_;
    setpoint_path path_;

    std::vector<knot> knots_; /* ring, in order of time */
    std::size_t first_ = 0;
    std::size_t count_ = 0;
    std::vector<setpoint> waiting_; /* free clock: setpoints not yet looked at, in order of arrival */
    std::uint8_t setpoint_counter_ = 0;

    std::int64_t start_ns_ = 0; /* of the line that the reference is on */
    reference_line line_;
    bool is_moving_ = false; /* on the way to the first knot */

    /* The reference under a limit of its velocity. */
    bool limits_reference_;
    velocity_follower follower_;
    reference_line limited_line_;
    std::int64_t limited_from_ns_ = 0;
    std::int64_t caught_up_ns_ = std::numeric_limits<std::int64_t>::max(); /* when it is on the other one again */

    std::int64_t clock_ticks_ = 0;
    std::int64_t next_latch_ns_;
    std::int64_t next_event_ns_ = 0;
};

} // namespace berth

#endif
