#include <algorithm>
#include <cmath>

#include "../../firmware/limits.h"
#include "../effects/active.h"
#include "replay.h"

namespace berth
{

namespace
{

constexpr double two_pi = 6.28318530717958647692;

/* Of a nonlinear block: an error of 1e-4 of a 10 Hz motion at 400 Hz. Corners that an effect makes in the motion lie
 * between the steps and hit the sensor's stiff spring: twice as many. */
constexpr int fine_steps_a_tick = 4;
constexpr int cornered_steps_a_tick = 8;

/* The limits of the robot, as those of the firmware: what is let through of a setpoint. */
class limiter
{
  public:
    explicit limiter(const rig &rig)
        : is_active_(rig.robot.velocity_limit_m_per_s != unlimited ||
                     rig.robot.acceleration_limit_m_per_s2 != unlimited)
    {
        constexpr double huge = 1e9; /* a limit that is not there, and whose square is still finite */
        config_ = rig.firmware;
        config_.limits = {-huge, huge, std::min(huge, rig.robot.velocity_limit_m_per_s),
                          std::min(huge, rig.robot.acceleration_limit_m_per_s2)};
    }
    limiter(const limiter &) = delete;
    limiter &operator=(const limiter &) = delete;

    void start(double position_m)
    {
        config_.manipulator.initial_position_m = position_m;
        limits_start(&limits_, &config_);
    }
    double take(double setpoint_m) { return is_active_ ? limits_step(&limits_, setpoint_m) : setpoint_m; }

  private:
    bool is_active_;
    app_config config_;
    limits limits_{};
};

/* The reference passes position_m at time_s, counted from the start of the segment; straight lines between. */
struct knot {
    double time_s;
    double position_m;
};

/* Setpoints of one segment as the robot takes them. */
std::vector<double> taken_setpoints(const rig &rig, const record &record, const record_segment &part)
{
    auto stages = active_stages(rig, &effect::on_setpoints);
    limiter limits(rig);
    std::vector<double> taken(part.end - part.begin);
    const double first_m = record.command_position_m[part.begin];
    double start_m = first_m;
    for (auto &stage : stages) {
        stage->start(start_m);
        start_m = stage->take(start_m);
    }
    limits.start(start_m);
    for (std::size_t n = 0; n < taken.size(); n++) {
        double setpoint_m = record.command_position_m[part.begin + n];
        for (auto &stage : stages) {
            setpoint_m = stage->take(setpoint_m);
        }
        taken[n] = limits.take(setpoint_m);
    }
    return taken;
}

/* A line that ends at a knot lasts one period; before it the reference stands. */
void add_knot(std::vector<knot> &knots, double time_s, double position_m, double period_s, bool holds)
{
    const double begin_s = holds ? time_s : time_s - period_s;
    if (!knots.empty() && begin_s > knots.back().time_s + 1e-9 * period_s) {
        knots.push_back({begin_s, knots.back().position_m});
    }
    knots.push_back({time_s, position_m});
}

std::vector<knot> reference_knots(const rig &rig, const record &record, const record_segment &part,
                                  const sample_events &events)
{
    const std::vector<double> taken = taken_setpoints(rig, record, part);
    const double period_s = record.period_s;
    const double dead_time_s = 1e-3 * rig.robot.dead_time_ms;
    const double drift = 1e-3 * value_of_effect(rig, "robot.dead_time_drift_ms_per_s");
    const bool holds = rig.robot.interpolation == interpolation::hold;
    const auto is_lost = [&](std::size_t n) {
        return !events.lost_command.empty() && events.lost_command[part.begin + n] != 0;
    };
    std::vector<knot> knots;
    knots.reserve(taken.size() + 16);
    if (rig.robot.clock == robot_clock::locked) {
        for (std::size_t n = 0; n < taken.size(); n++) {
            const double sent_s = period_s * static_cast<double>(n);
            if (!is_lost(n)) {
                const double since_start_s = record.time_s[part.begin + n] - record.time_s.front();
                add_knot(knots, sent_s + dead_time_s + drift * since_start_s, taken[n], period_s, holds);
            }
        }
        return knots;
    }
    const double clock_period_s = period_s * (1.0 + 1e-6 * rig.robot.clock_drift_ppm);
    const double arrival_s = 1e-9 * static_cast<double>(frame_time_ns(rig.bus, 8));
    double latch_s = std::fmod(1e-3 * rig.robot.clock_phase_ms, period_s);
    std::size_t next = 0;
    while (next < taken.size()) {
        std::size_t newest = next;
        while (newest < taken.size() && period_s * static_cast<double>(newest) + arrival_s <= latch_s) {
            newest++;
        }
        if (newest > next) {
            add_knot(knots, latch_s + dead_time_s, taken[newest - 1], clock_period_s, holds);
            next = newest;
        }
        latch_s += clock_period_s;
    }
    return knots;
}

/* Walks along the reference. */
class reference
{
  public:
    reference(const std::vector<knot> &knots, bool holds) : knots_(knots), holds_(holds) {}

    double at(double time_s)
    {
        while (next_ < knots_.size() && knots_[next_].time_s <= time_s) {
            next_++;
        }
        if (next_ == 0) {
            return knots_.front().position_m;
        }
        const knot &before = knots_[next_ - 1];
        if (holds_ || next_ == knots_.size()) {
            return before.position_m;
        }
        const knot &after = knots_[next_];
        return before.position_m +
               (after.position_m - before.position_m) * (time_s - before.time_s) / (after.time_s - before.time_s);
    }

  private:
    const std::vector<knot> &knots_;
    bool holds_;
    std::size_t next_ = 0;
};

/* r'' = w^2 (u - r) - 2 z w r', exact where u is straight within a step: r follows the line u - 2 z u'/w, and what
 * is left of the start dies away as a damped oscillation. */
class transfer_behaviour
{
  public:
    explicit transfer_behaviour(const rig &rig)
        : w_(two_pi * rig.robot.transfer_frequency_Hz), z_(rig.robot.transfer_damping_ratio)
    {
    }
    void start(double position_m)
    {
        before_m_ = position_m_ = position_m;
        velocity_m_per_s_ = 0.0;
    }
    double advance(double goal_m, double step_s)
    {
        if (step_s != steps_[0].step_s) {
            if (step_s != steps_[1].step_s) {
                steps_[1] = transition_over(step_s);
            }
            std::swap(steps_[0], steps_[1]);
        }
        const transition &t = steps_[0];
        const double rise = (goal_m - before_m_) / step_s;
        const double behind_m = 2.0 * z_ * rise / w_;
        const double offset_m = position_m_ - (before_m_ - behind_m);
        const double rate = velocity_m_per_s_ - rise;
        position_m_ = goal_m - behind_m + t.a[0] * offset_m + t.a[1] * rate;
        velocity_m_per_s_ = rise + t.a[2] * offset_m + t.a[3] * rate;
        before_m_ = goal_m;
        return position_m_;
    }

  private:
    struct transition {
        double step_s = -1.0;
        double a[4] = {};
    };
    transition transition_over(double step_s) const
    {
        const double under = 1.0 - z_ * z_;
        const double wd = w_ * std::sqrt(std::max(1e-9, std::abs(under)));
        /* exp(-z w h) cosh(wd h) overflows in its parts where the damping is large. */
        const double grow = under > 0.0 ? 0.0 : wd * step_s;
        const double decay = std::exp(-z_ * w_ * step_s + grow);
        const double c = under > 0.0 ? std::cos(wd * step_s) : 0.5 * (1.0 + std::exp(-2.0 * grow));
        const double s = under > 0.0 ? std::sin(wd * step_s) : 0.5 * (1.0 - std::exp(-2.0 * grow));
        return {step_s,
                {decay * (c + z_ * w_ * s / wd), decay * s / wd, -decay * w_ * w_ * s / wd,
                 decay * (c - z_ * w_ * s / wd)}};
    }

    double w_;
    double z_;
    transition steps_[2];
    double before_m_ = 0.0;
    double position_m_ = 0.0;
    double velocity_m_per_s_ = 0.0;
};

} // namespace

tick_steps divide_tick(const rig &rig, double period_s, int steps_min)
{
    const bool knots_wander =
        rig.robot.clock == robot_clock::free || value_of_effect(rig, "robot.dead_time_drift_ms_per_s") != 0.0;
    const double knot_s = knots_wander ? 0.0 : std::fmod(1e-3 * rig.robot.dead_time_ms, period_s);
    const double late =
        (1e-3 * rig.sensor.delay_ms - std::fmod(1e-3 * rig.sensor.sample_phase_ms, period_s)) / period_s;
    const double whole = std::ceil(late - 1e-9);
    const double sample_s = std::max(0.0, (whole - late) * period_s);

    const double least_s = 1e-6 * period_s;
    std::vector<double> ends;
    for (const double end_s : {knot_s, sample_s}) {
        if (end_s > least_s && end_s < period_s - least_s) {
            ends.push_back(end_s);
        }
    }
    std::sort(ends.begin(), ends.end());
    ends.push_back(period_s);
    const double step_max_s = period_s / std::max(steps_min, knots_wander ? fine_steps_a_tick : 1) * (1.0 + 1e-9);
    tick_steps tick;
    tick.ticks_late = static_cast<std::ptrdiff_t>(whole);
    double begin_s = 0.0;
    for (const double end_s : ends) {
        if (end_s - begin_s < least_s) {
            continue;
        }
        const int parts = static_cast<int>(std::ceil((end_s - begin_s) / step_max_s));
        for (int i = 0; i < parts; i++) {
            tick.duration_s.push_back((end_s - begin_s) / parts);
            tick.kind.push_back(tick.kinds);
        }
        tick.kinds++;
        begin_s = end_s;
        if (std::abs(end_s - sample_s) < least_s) {
            tick.sample_after = tick.duration_s.size();
        }
    }
    if (tick.sample_after == tick.count()) {
        tick.sample_after = 0; /* the end of a tick is the start of the next one */
        tick.ticks_late -= 1;
    }
    return tick;
}

void replay_robot(const rig &rig, const record &record, const sample_events &events, bool fine, robot_motion &motion)
{
    const double period_s = record.period_s;
    const bool holds = rig.robot.interpolation == interpolation::hold;
    const bool has_motion_effect = !active_stages(rig, &effect::on_motion).empty();
    const int steps = has_motion_effect                      ? cornered_steps_a_tick
                      : fine || rig.has_transfer_behaviour() ? fine_steps_a_tick
                                                             : 1;
    motion.tick = divide_tick(rig, period_s, steps);
    motion.position_m.resize(record.size() * motion.tick.count() + record.segments.size());
    motion.at_tick_m.resize(record.size());

    double *out = motion.position_m.data();
    for (const record_segment &part : record.segments) {
        const std::vector<knot> knots = reference_knots(rig, record, part, events);
        if (knots.empty()) {
            continue;
        }
        reference line(knots, holds);
        auto stages = active_stages(rig, &effect::on_motion);
        transfer_behaviour transfer(rig);
        double position_m = knots.front().position_m;
        transfer.start(position_m);
        for (auto &stage : stages) {
            stage->start(position_m);
            position_m = stage->advance(position_m, motion.tick.duration_s[0]);
        }
        *out++ = position_m;
        for (std::size_t n = part.begin; n < part.end; n++) {
            motion.at_tick_m[n] = position_m;
            double time_s = period_s * static_cast<double>(n - part.begin);
            for (const double step_s : motion.tick.duration_s) {
                time_s += step_s;
                position_m = line.at(time_s);
                if (rig.has_transfer_behaviour()) {
                    position_m = transfer.advance(position_m, step_s);
                }
                for (auto &stage : stages) {
                    position_m = stage->advance(position_m, step_s);
                }
                *out++ = position_m;
            }
        }
    }
}

} // namespace berth
