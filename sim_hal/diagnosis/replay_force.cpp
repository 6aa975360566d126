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
        const std::size_t first = plant_.one_sided ? 0 : 1;
        const std::size_t last = grip_force_N_ > 0.0 ? 2 : 1;
        maps_.resize(motion.tick.kinds);
        for (std::size_t i = 0; i < motion.tick.count(); i++) {
            for (std::size_t state = first; state <= last; state++) {
                if (i == 0 || motion.tick.kind[i] != motion.tick.kind[i - 1]) {
                    maps_[motion.tick.kind[i]][state] =
                        make_step_map(plant_, static_cast<grip>(state), motion.tick.duration_s[i]);
                }
            }
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
    void advance(std::size_t step, double from_m, double to_m, double time_s)
    {
        const double step_s = motion_.tick.duration_s[step];
        const double velocity_m_per_s = (to_m - from_m) / step_s;
        if (plant_.one_sided) {
            grip_ = object_force_N() > 0.0 ? grip::holds : grip::free_of_material;
        } else if (grip_force_N_ > 0.0) {
            watch_grip({from_m, velocity_m_per_s});
        }
        const bool is_crossley = impact_damping_s_per_m_ > 0.0 && grip_ == grip::holds;
        const auto state = static_cast<std::size_t>(is_crossley ? grip::free_of_material : grip_);
        const step_map &map = maps_[motion_.tick.kind[step]][state];
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
    std::vector<std::array<step_map, static_cast<std::size_t>(grip::count)>> maps_; /* by kind of step */
    std::vector<std::unique_ptr<force_stage>> forces_;
    body_state state_{};
    grip grip_ = grip::holds;
    reference_line line_{};
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
    const double late_s = 1e-3 * rig.sensor.delay_ms; /* for what depends on the time of the sample */
    const tick_steps &tick = motion.tick;
    object_replay object(rig, motion);
    force_N.assign(record.size(), 0.0);
    std::vector<double> sampled;
    const double *position_m = motion.position_m.data();
    for (const record_segment &part : record.segments) {
        const std::size_t count = part.end - part.begin;
        electronics electronics(rig);
        auto filters = active_stages(rig, &effect::on_force);
        object.start(rig, *position_m, record.time_s[part.begin] - record.time_s.front());
        double now_N = object.measured_N();
        const double rest_N = now_N;
        for (auto &filter : filters) {
            filter->start(now_N);
        }
        sampled.resize(count);
        for (std::size_t n = 0; n < count; n++) {
            double time_s = record.time_s[part.begin + n] - record.time_s.front();
            for (std::size_t step = 0; step < tick.count(); step++) {
                if (step == tick.sample_after) {
                    sampled[n] = filters.empty() ? object.measured_N() : now_N;
                }
                object.advance(step, position_m[0], position_m[1], time_s);
                time_s += tick.duration_s[step];
                position_m++;
                if (!filters.empty()) {
                    now_N = object.measured_N();
                    for (auto &filter : filters) {
                        now_N = filter->advance(now_N, tick.duration_s[step]);
                    }
                }
            }
        }
        position_m++;
        for (std::size_t n = 0; n < count; n++) {
            const std::ptrdiff_t from = static_cast<std::ptrdiff_t>(n) - tick.ticks_late;
            const double time_s = record.time_s[part.begin + n] - record.time_s.front() - late_s;
            force_N[part.begin + n] =
                electronics.take(from < 0 ? rest_N : sampled[static_cast<std::size_t>(from)], time_s);
        }
    }
}

} // namespace berth
