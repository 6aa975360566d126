/* Sensor spring, object and force low-pass in steps, with effects on the object: exact where it is linear, with the
 * robot going straight within a step; further forces act as they are in the middle of one. */
#ifndef SIM_HAL_SOLVER_OBJECT_STEPS_H
#define SIM_HAL_SOLVER_OBJECT_STEPS_H

#include <algorithm>
#include <array>
#include <memory>
#include <vector>

#include "../effects/stages.h"
#include "../plant/plant.h"

namespace berth
{

/* Steps a tick that keep a 10 Hz motion at 400 Hz to an error of 1e-4. Corners that an effect makes in the robot's
 * motion lie between the steps and hit the sensor's stiff spring: twice as many. */
constexpr int fine_steps_a_tick = 4;
constexpr int cornered_steps_a_tick = 8;

/* Of a filter after the low-pass, which takes the force to be straight within a step, while the sensor's spring
 * rings: with one step a lag of 12 ms makes the object look 3 % heavier. */
constexpr int filtered_steps_a_tick = 8;

/* Of a contact that stiffens with the velocity. */
constexpr int stiffening_steps_a_tick = 8;

/* Steps a tick that the object needs: one where it is linear. */
int object_steps_a_tick(const rig &rig);

/* The robot's way over a step: straight, or a parabola that passes `bulge_m` beside the line on average. */
struct robot_way {
    double from_m;
    double to_m;
    double bulge_m = 0.0;

    double velocity_m_per_s(double step_s) const
    {
        return (to_m - from_m + 6.0 * bulge_m) / step_s;
    } /* at its begin */
    double acceleration_m_per_s2(double step_s) const { return -12.0 * bulge_m / (step_s * step_s); }

    /* Number `i` of `count` equal parts. */
    robot_way part(int i, int count) const
    {
        const double step = 1.0 / count;
        return {at(step * i), at(step * (i + 1)), bulge_m * step * step};
    }

  private:
    double at(double place) const
    {
        return from_m + (to_m - from_m) * place + 6.0 * bulge_m * place * (1.0 - place);
    }
};

class object_steps
{
  public:
    static constexpr std::size_t rows = 4;   /* object and low-pass, as the first four of plant_index */
    static constexpr std::size_t inputs = 4; /* u, u', u'', 1 */
    static constexpr std::size_t columns = rows + inputs + 1; /* and a further force on the object */

    /* Where a contact begins or ends on the way. */
    static constexpr int fine_parts = 16;
    /* Where dry friction may turn: with 16 steps a tick friction of 370 times the noise leaves nothing of itself,
     * with 4 as much as 0.8 of the noise. */
    static constexpr int turning_parts = 4;

    enum class grip : std::size_t { free_of_material, holds, is_lost, count };

    /* (state, u, u', u'', 1, n) over one step; by columns. */
    struct step_map {
        std::array<std::array<double, rows>, columns> column{};
    };
    using step_maps = std::array<step_map, static_cast<std::size_t>(grip::count)>; /* one for each grip */
    using body_state = std::array<double, rows>;

    explicit object_steps(const rig &rig);

    step_maps make_maps(double step_s) const;

    /* Of the short steps into which advance_watching divides one of `step_s`; empty where it divides none. */
    step_maps make_fine_maps(double step_s) const { return watches() ? make_maps(step_s / parts()) : step_maps{}; }

    /* At rest with the robot at `position_m`. */
    void start(const rig &rig, double position_m, double time_s);

    void advance(const step_maps &maps, double step_s, const robot_way &way, double time_s)
    {
        begin_step(step_s, way, time_s);
        state_ = state_after(maps, grip_, step_s, time_s);
        end_step(step_s, way);
    }

    /* The same; where a contact begins or ends on the way or the grip gives way, in `fine_parts` steps, for which
     * `fine` are the maps, and in the one of them where it does, each mode counts for its share of the time. Where
     * dry friction may turn, in `turning_parts` steps. */
    void advance_watching(const step_maps &maps, const step_maps &fine, double step_s, const robot_way &way,
                          double time_s)
    {
        if (!switches()) {
            if (friction_N_ > 0.0 && is_divided(maps, step_s, way)) {
                advance_in_parts(fine, step_s, way, time_s);
            } else {
                advance(maps, step_s, way, time_s);
            }
            return;
        }
        const body_state before = state_;
        const grip grip_before = grip_;
        if (!forces_.empty()) { /* these remember steps, which cannot be taken back */
            if (!will_switch(maps, step_s, way, time_s)) {
                advance(maps, step_s, way, time_s);
                return;
            }
        } else {
            advance(maps, step_s, way, time_s);
            if (margin() >= 0.0) {
                return;
            }
        }
        state_ = before;
        grip_ = grip_before;
        for (int i = 0; i < fine_parts; i++) {
            advance_switching(fine, step_s / fine_parts, way.part(i, fine_parts), time_s);
        }
    }

    /* Some steps are divided. */
    bool watches() const { return switches() || friction_N_ > 0.0; }

    /* There is a contact that begins and ends, or a grip that closes or gives way. */
    bool switches() const { return switches_; }

    /* Once it was started: a step is a linear map, the one of a grip that holds, of the robot, the state and what a
     * further force keeps. */
    bool is_linear() const
    {
        return !switches() && (forces_.empty() || (forces_.size() == 1 && forces_[0]->is_linear()));
    }

    /* Of the one that it has if it is linear. */
    bool has_further_force() const { return !forces_.empty(); }
    linear_law further_law(const step_map &map, double step_s) const
    {
        return forces_[0]->law(step_s, -map.column[columns - 1][object_velocity]);
    }

    /* The robot jumps to `to_m`. */
    void jump(double to_m);

    double spring_N() const { return grip_ == grip::is_lost ? 0.0 : plant_.spring_force_N(full_state(), line_); }
    double measured_N() const
    {
        return grip_ == grip::is_lost && plant_.filter_order == 0 ? 0.0
                                                                  : plant_.measured_force_N(full_state(), line_);
    }

    const body_state &state() const { return state_; }
    void set_state(const body_state &state) { state_ = state; }
    /* Where the robot is, and how fast it came there. */
    reference_line robot_line() const { return {line_.position_m + gripped_at_m_, line_.velocity_m_per_s}; }

  private:
    int parts() const { return switches() ? fine_parts : turning_parts; }
    plant_state full_state() const
    {
        plant_state full = plant_state::Zero();
        std::copy(state_.begin(), state_.end(), full.data());
        return full;
    }
    double depth_m() const { return state_[object_position] - plant_.surface_m; }
    /* Of the material, were it to pull as well. */
    double pressed_N() const
    {
        const double k = plant_.stiffness_N_per_m;
        return impact_damping_s_per_m_ > 0.0
                   ? k * depth_m() * (1.0 + impact_damping_s_per_m_ * state_[object_velocity])
                   : k * depth_m() + plant_.damping_N_s_per_m * state_[object_velocity];
    }
    double gap_m() const { return line_.position_m - state_[object_position]; }
    double pull_N() const
    {
        return plant_.sensor_stiffness_N_per_m * gap_m() +
               plant_.sensor_damping_N_s_per_m * (line_.velocity_m_per_s - state_[object_velocity]);
    }
    /* How far the mode is from its end; below 0: beyond it. */
    double margin() const
    {
        if (plant_.one_sided) {
            const double touching_N = std::min(plant_.stiffness_N_per_m * depth_m(), pressed_N());
            return grip_ == grip::holds ? touching_N : -touching_N;
        }
        if (grip_force_N_ <= 0.0 || is_released_ || is_open_) {
            return 1.0;
        }
        const double spare_N = pull_N() + grip_force_N_;
        return grip_ == grip::holds ? spare_N : -std::min(plant_.sensor_stiffness_N_per_m * gap_m(), spare_N);
    }
    grip next_grip() const
    {
        return grip_ != grip::holds ? grip::holds : plant_.one_sided ? grip::free_of_material : grip::is_lost;
    }
    /* Not above 0: nothing is touched. */
    double object_force_N() const { return depth_m() > 0.0 ? pressed_N() : -1.0; }
    /* Where the robot is and what is touched as a step begins. */
    void begin_step(double step_s, const robot_way &way, double time_s)
    {
        is_released_ = is_released_ || time_s >= grip_release_s_;
        if (is_open_ && time_s >= grip_close_s_) {
            is_open_ = false;
            gripped_at_m_ = way.from_m - state_[object_position];
            grip_ = grip::holds;
        }
        line_ = {way.from_m - gripped_at_m_, way.velocity_m_per_s(step_s)};
        bend_m_per_s2_ = way.acceleration_m_per_s2(step_s);
        grip_ = is_released_ || is_open_ ? grip::is_lost
                : plant_.one_sided       ? (object_force_N() > 0.0 ? grip::holds : grip::free_of_material)
                : margin() < 0.0         ? next_grip()
                                         : grip_;
    }
    void end_step(double step_s, const robot_way &way)
    {
        line_ = {way.to_m - gripped_at_m_,
                 way.velocity_m_per_s(step_s) + way.acceleration_m_per_s2(step_s) * step_s};
    }
    bool is_crossley(grip mode) const { return impact_damping_s_per_m_ > 0.0 && mode == grip::holds; }
    const step_map &map_of(const step_maps &maps, grip mode) const
    {
        return maps[static_cast<std::size_t>(is_crossley(mode) ? grip::free_of_material : mode)];
    }
    /* After a step that begins with the robot on `line_`, without further forces. */
    body_state state_alone_after(const step_map &map) const
    {
        /* The state comes last: what the robot does need not wait for the step before. */
        body_state next{};
        const double input[inputs] = {line_.position_m, line_.velocity_m_per_s, bend_m_per_s2_, 1.0};
        for (std::size_t column = 0; column < inputs; column++) {
            for (std::size_t row = 0; row < rows; row++) {
                next[row] += map.column[rows + column][row] * input[column];
            }
        }
        for (std::size_t column = 0; column < rows; column++) {
            for (std::size_t row = 0; row < rows; row++) {
                next[row] += map.column[column][row] * state_[column];
            }
        }
        return next;
    }
    body_state state_after(const step_maps &maps, grip mode, double step_s, double time_s)
    {
        const step_map &map = map_of(maps, mode);
        body_state next = state_alone_after(map);
        if (!forces_.empty() || is_crossley(mode)) {
            further_N_ = further_force_N(map, next, is_crossley(mode), time_s, step_s);
            push(map, further_N_, next);
        }
        return next;
    }
    static void push(const step_map &map, double force_N, body_state &state)
    {
        for (std::size_t row = 0; row < rows; row++) {
            state[row] += map.column[columns - 1][row] * force_N;
        }
    }
    /* What decides ends beyond its threshold with the further forces of the step before. */
    bool will_switch(const step_maps &maps, double step_s, const robot_way &way, double time_s);
    bool is_divided(const step_maps &maps, double step_s, const robot_way &way) const;
    void advance_in_parts(const step_maps &fine, double step_s, const robot_way &way, double time_s);
    void advance_switching(const step_maps &maps, double step_s, const robot_way &way, double time_s);
    double further_force_N(const step_map &map, const body_state &alone, bool is_crossley, double time_s,
                           double step_s);

    plant plant_; /* its robot is where it is told to be */
    double grip_force_N_;
    double grip_close_s_; /* 0: gripped from the start */
    double grip_release_s_;
    bool is_open_ = false;      /* has not closed yet */
    bool is_released_ = false;  /* for good */
    double gripped_at_m_ = 0.0; /* robot less object, at the instant */
    double impact_damping_s_per_m_;
    double friction_N_; /* dry */
    bool switches_;
    std::vector<std::unique_ptr<force_stage>> forces_;
    double further_N_ = 0.0; /* of the last step */
    body_state state_{};
    grip grip_ = grip::holds;
    reference_line line_{};      /* of the robot, counted from where it does not pull the object */
    double bend_m_per_s2_ = 0.0; /* of its way over this step */
};

} // namespace berth

#endif
