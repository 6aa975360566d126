#include "effect_solver.h"

#include <cmath>

namespace berth
{

namespace
{

std::int64_t longest_step_ns(const rig &rig)
{
    const bool has_corners = !active_stages(rig, &effect::on_motion).empty();
    const int steps_a_tick =
        std::max(has_corners ? cornered_steps_a_tick : fine_steps_a_tick, object_steps_a_tick(rig));
    const std::int64_t step_ns = config_period_ns(&rig.firmware) / steps_a_tick;
    const std::int64_t contact_ns = std::llround(rig.solver.contact_step_us * 1e3);
    return std::max<std::int64_t>(1,
                                  rig.object.kind == object_kind::contact ? std::min(step_ns, contact_ns) : step_ns);
}

} // namespace

effect_solver::effect_solver(const rig &rig, double reference_m)
    : drive_(rig), object_(rig), filters_(active_stages(rig, &effect::on_force)), step_max_ns_(longest_step_ns(rig))
{
    object_.start(rig, drive_.start(reference_m), 0.0);
    force_N_ = object_.measured_N();
    for (auto &filter : filters_) {
        filter->start(force_N_);
        force_N_ = filter->jump(force_N_);
    }
}

void effect_solver::advance(const reference_line &line, std::int64_t duration_ns)
{
    const std::int64_t steps = (duration_ns + step_max_ns_ - 1) / step_max_ns_;
    std::int64_t done_ns = 0;
    for (std::int64_t i = 1; i <= steps; i++) {
        const std::int64_t end_ns = duration_ns * i / steps;
        step(line.position_m + line.velocity_m_per_s * static_cast<double>(end_ns) * 1e-9, end_ns - done_ns);
        done_ns = end_ns;
    }
}

void effect_solver::step(double reference_m, std::int64_t duration_ns)
{
    const double step_s = static_cast<double>(duration_ns) * 1e-9;
    const double from_m = object_.robot_line().position_m;
    const double to_m = drive_.advance(reference_m, step_s);
    const known_step &known = maps_for(duration_ns);
    object_.advance_watching(known.maps, known.fine, step_s, {from_m, to_m}, static_cast<double>(now_ns_) * 1e-9);
    now_ns_ += duration_ns;
    force_N_ = object_.measured_N();
    for (auto &filter : filters_) {
        force_N_ = filter->advance(force_N_, step_s);
    }
}

const effect_solver::known_step &effect_solver::maps_for(std::int64_t duration_ns)
{
    for (known_step &known : known_) {
        if (known.duration_ns == duration_ns) {
            return known;
        }
    }
    known_step &made = known_[next_known_];
    next_known_ = (next_known_ + 1) % known_.size();
    made.duration_ns = duration_ns;
    made.maps = object_.make_maps(static_cast<double>(duration_ns) * 1e-9);
    made.fine = object_.make_fine_maps(static_cast<double>(duration_ns) * 1e-9);
    return made;
}

beam_state effect_solver::state() const
{
    beam_state full = beam_state::Zero();
    std::copy(object_.state().begin(), object_.state().end(), full.data());
    full(robot_position) = robot_position_m();
    full(robot_velocity) = robot_velocity_m_per_s();
    return full;
}

void effect_solver::set_state(const beam_state &state)
{
    object_steps::body_state body;
    std::copy(state.data(), state.data() + body.size(), body.begin());
    object_.set_state(body);
}

} // namespace berth
