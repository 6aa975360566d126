#include <algorithm>
#include <array>
#include <cmath>

#include "../effects/active.h"
#include "../plant/plant.h"
#include "../solver/exponential.h"
#include "../solver/generator.h"
#include "replay.h"

namespace berth
{

namespace
{

constexpr int rows = 4;           /* object and low-pass, as the first four of plant_index */
constexpr int columns = rows + 4; /* and u, u', 1, a further force on the object */

rig without_transfer(const rig &original)
{
    rig made = original; /* the motion is that of the robot already */
    made.robot.transfer_frequency_Hz = unlimited;
    return made;
}

enum class grip { free_of_material, holds, is_lost, count };

/* (state, u, u', 1, n) over one step; by columns. */
struct step_map {
    std::array<std::array<double, rows>, columns> column{};
};

step_map make_step_map(const plant &original, grip state, double step_s)
{
    plant plant = original;
    if (state == grip::is_lost) {
        plant.sensor_stiffness_N_per_m = 0.0;
        plant.sensor_damping_N_s_per_m = 0.0;
    }
    const plant_generator full =
        make_generator(plant, state == grip::free_of_material ? contact_mode::free : contact_mode::attached);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(columns, columns);
    a.topLeftCorner<rows, rows>() = full.topLeftCorner<rows, rows>();
    a.block<rows, 3>(0, rows) = full.block<rows, 3>(0, plant_state_count);
    a(rows, rows + 1) = 1.0;
    a(object_velocity, columns - 1) = -1.0 / plant.mass_kg;
    const Eigen::MatrixXd e = balanced_exponential(a * step_s);
    step_map map;
    for (int column = 0; column < columns; column++) {
        for (int row = 0; row < rows; row++) {
            map.column[static_cast<std::size_t>(column)][static_cast<std::size_t>(row)] = e(row, column);
        }
    }
    return map;
}

using body_state = std::array<double, rows>;

class object_replay
{
  public:
    object_replay(const rig &rig, const robot_motion &motion)
        : plant_(without_transfer(rig)), motion_(motion), grip_force_N_(value_of_effect(rig, "object.grip_force_N")),
          impact_damping_s_per_m_(value_of_effect(rig, "object.impact_damping_s_per_m"))
    {
        const int first = plant_.one_sided ? 0 : 1;
        const int last = grip_force_N_ > 0.0 ? 2 : 1;
        for (int state = first; state <= last; state++) {
            before_[static_cast<std::size_t>(state)] =
                make_step_map(plant_, static_cast<grip>(state), motion.step_before_s);
            after_[static_cast<std::size_t>(state)] =
                make_step_map(plant_, static_cast<grip>(state), motion.step_after_s);
        }
    }

    void start(const rig &rig, double position_m, double time_s)
    {
        const plant_state rest = plant_.at_rest(position_m);
        std::copy(rest.data(), rest.data() + rows, state_.begin());
        forces_ = active_stages(rig, &effect::on_body, "object");
        grip_ = grip::holds;
        for (auto &force : forces_) {
            force->start({state_[object_position], state_[object_position], 0.0, time_s, 0.0});
        }
    }

    /* One step with the robot going straight from `from_m` to `to_m`. */
    void advance(bool before_knot, double from_m, double to_m, double time_s)
    {
        const double step_s = before_knot ? motion_.step_before_s : motion_.step_after_s;
        const double velocity_m_per_s = (to_m - from_m) / step_s;
        if (plant_.one_sided) {
            grip_ = object_force_N() > 0.0 ? grip::holds : grip::free_of_material;
        } else if (grip_force_N_ > 0.0) {
            watch_grip({from_m, velocity_m_per_s});
        }
        const bool is_crossley = impact_damping_s_per_m_ > 0.0 && grip_ == grip::holds;
        const step_map &map =
            (before_knot ? before_ : after_)[static_cast<std::size_t>(is_crossley ? grip::free_of_material : grip_)];
        body_state next{};
        for (std::size_t column = 0; column < rows; column++) {
            for (std::size_t row = 0; row < rows; row++) {
                next[row] += map.column[column][row] * state_[column];
            }
        }
        const double inputs[3] = {from_m, velocity_m_per_s, 1.0};
        for (std::size_t column = 0; column < 3; column++) {
            for (std::size_t row = 0; row < rows; row++) {
                next[row] += map.column[rows + column][row] * inputs[column];
            }
        }
        if (!forces_.empty() || is_crossley) {
            add_forces(map, next, is_crossley, time_s, step_s);
        }
        state_ = next;
        line_ = {to_m, velocity_m_per_s};
    }

    double measured_N() const
    {
        plant_state full = plant_state::Zero();
        std::copy(state_.begin(), state_.end(), full.data());
        return grip_ == grip::is_lost && plant_.filter_order == 0 ? 0.0 : plant_.measured_force_N(full, line_);
    }

    double rate_N_per_s() const { return plant_.filter_order == 2 ? state_[filter_rate] : 0.0; }

  private:
    double depth_m() const { return state_[object_position] - plant_.surface_m; }
    double object_force_N() const
    {
        const double depth = depth_m();
        const double k = plant_.stiffness_N_per_m;
        return impact_damping_s_per_m_ > 0.0 ? k * depth * (1.0 + impact_damping_s_per_m_ * state_[object_velocity])
               : depth > 0.0                 ? k * depth + plant_.damping_N_s_per_m * state_[object_velocity]
                                             : -1.0;
    }

    void watch_grip(const reference_line &line)
    {
        const double gap_m = line.position_m - state_[object_position];
        const double spring_N = plant_.sensor_stiffness_N_per_m * gap_m +
                                plant_.sensor_damping_N_s_per_m * (line.velocity_m_per_s - state_[object_velocity]);
        if (grip_ == grip::holds && spring_N < -grip_force_N_) {
            grip_ = grip::is_lost;
        } else if (grip_ == grip::is_lost && gap_m >= 0.0) {
            grip_ = grip::holds;
        }
    }

    void add_forces(const step_map &map, body_state &next, bool is_crossley, double time_s, double step_s)
    {
        const auto &push = map.column[columns - 1];
        const double middle_m = 0.5 * (state_[object_position] + next[object_position]);
        double sum_N = 0.0;
        if (is_crossley) {
            const double depth = middle_m - plant_.surface_m;
            const double rate = 0.5 * (state_[object_velocity] + next[object_velocity]);
            sum_N += std::max(0.0, plant_.stiffness_N_per_m * depth * (1.0 + impact_damping_s_per_m_ * rate));
        }
        for (auto &force : forces_) {
            sum_N += force->force_N({middle_m, middle_m, next[object_velocity] + push[object_velocity] * sum_N,
                                     time_s, -push[object_velocity]},
                                    step_s);
        }
        for (std::size_t row = 0; row < rows; row++) {
            next[row] += push[row] * sum_N;
        }
    }

    plant plant_;
    const robot_motion &motion_;
    double grip_force_N_;
    double impact_damping_s_per_m_;
    std::array<step_map, static_cast<std::size_t>(grip::count)> before_;
    std::array<step_map, static_cast<std::size_t>(grip::count)> after_;
    std::vector<std::unique_ptr<force_stage>> forces_;
    body_state state_{};
    grip grip_ = grip::holds;
    reference_line line_{};
};

/* The force over time, kept long enough to be sampled late. */
class force_history
{
  public:
    force_history(double delay_s, double period_s, const robot_motion &motion) : motion_(motion)
    {
        const double ticks = delay_s / period_s;
        whole_ = static_cast<std::ptrdiff_t>(std::ceil(ticks - 1e-9));
        into_tick_s_ = (static_cast<double>(whole_) - ticks) * period_s;
        if (into_tick_s_ < 1e-9 * period_s) {
            into_tick_s_ = 0.0;
        }
    }

    /* Ticks by which a sample is late, rounded up; the sample itself lies `into_tick_s` after the older tick. */
    std::ptrdiff_t ticks_late() const { return whole_; }

    /* Whether the sample of a tick lies in the step that ended at `end_s` of the tick, and its value then. */
    bool is_in_step(double begin_s, double end_s) const
    {
        return into_tick_s_ > 0.0 && into_tick_s_ > begin_s && into_tick_s_ <= end_s + 1e-12;
    }
    double into_tick_s() const { return into_tick_s_; }
    bool is_at_tick() const { return into_tick_s_ == 0.0; }

  private:
    const robot_motion &motion_;
    std::ptrdiff_t whole_;
    double into_tick_s_;
};

class electronics
{
  public:
    explicit electronics(const rig &rig) : rig_(rig), stages_(active_stages(rig, &effect::on_samples)) {}
    double take(double force_N, double time_s)
    {
        for (auto &stage : stages_) {
            force_N = stage->take(force_N, time_s);
        }
        force_N += rig_.sensor.bias_N;
        return std::min(std::max(force_N, -rig_.sensor.saturation_N), rig_.sensor.saturation_N);
    }

  private:
    const rig &rig_;
    std::vector<std::unique_ptr<sample_stage>> stages_;
};

} // namespace

bool object_is_nonlinear(const rig &rig)
{
    return rig.object.kind == object_kind::contact || value_of_effect(rig, "object.grip_force_N") > 0.0 ||
           !active_stages(rig, &effect::on_body, "object").empty();
}

void replay_force(const rig &rig, const record &record, const robot_motion &motion, std::vector<double> &force_N)
{
    const double period_s = record.period_s;
    const double delay_s = 1e-3 * (rig.sensor.delay_ms - std::fmod(rig.sensor.sample_phase_ms, 1e3 * period_s));
    const force_history history(delay_s, period_s, motion);
    object_replay object(rig, motion);
    force_N.assign(record.size(), 0.0);
    std::vector<double> sampled;
    const double *position_m = motion.position_m.data();
    for (const record_segment &part : record.segments) {
        const std::size_t count = part.end - part.begin;
        electronics electronics(rig);
        auto filters = active_stages(rig, &effect::on_force);
        object.start(rig, *position_m, record.time_s[part.begin] - record.time_s.front());
        double before_N = object.measured_N();
        for (auto &filter : filters) {
            filter->start(before_N);
        }
        sampled.assign(count + 1, before_N);
        const double rest_N = before_N;
        for (std::size_t n = 0; n < count; n++) {
            const double tick_s = record.time_s[part.begin + n] - record.time_s.front();
            double end_s = 0.0;
            if (history.is_at_tick()) {
                sampled[n] = before_N;
            }
            for (int i = 0; i < motion.steps(); i++) {
                const bool before_knot = i < motion.steps_before_knot;
                const double begin_s = end_s;
                const double step_s = before_knot ? motion.step_before_s : motion.step_after_s;
                end_s += step_s;
                const double rate_before = object.rate_N_per_s();
                object.advance(before_knot, position_m[0], position_m[1], tick_s + begin_s);
                position_m++;
                double now_N = object.measured_N();
                const bool is_smooth = filters.empty();
                for (auto &filter : filters) {
                    now_N = filter->advance(now_N, step_s);
                }
                if (history.is_in_step(begin_s, end_s)) {
                    const double s = (history.into_tick_s() - begin_s) / step_s;
                    double value = before_N + s * (now_N - before_N);
                    if (is_smooth && rig.sensor.low_pass_order == 2) { /* Hermite: value and rate at both ends */
                        const double a = rate_before * step_s - (now_N - before_N);
                        const double b = -object.rate_N_per_s() * step_s + (now_N - before_N);
                        value += s * (1.0 - s) * ((1.0 - s) * a + s * b);
                    }
                    sampled[n] = value;
                }
                before_N = now_N;
            }
        }
        position_m++;
        const std::ptrdiff_t late = history.ticks_late();
        for (std::size_t n = 0; n < count; n++) {
            const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(n) - late;
            const double time_s = record.time_s[part.begin + n] - record.time_s.front() - delay_s;
            force_N[part.begin + n] =
                electronics.take(from < 0 ? rest_N : sampled[static_cast<std::size_t>(from)], time_s);
        }
    }
}

} // namespace berth
