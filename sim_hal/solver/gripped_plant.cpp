#include "gripped_plant.h"

#include <algorithm>

namespace berth
{

gripped_plant::gripped_plant(const rig &rig, double reference_m)
    : rig_(rig), equations_(rig), close_ns_(event_ns(grip_closes_s(rig))),
      release_ns_(event_ns(rig.run.grip_release_s)), next_change_ns_(close_ns_ > 0 ? close_ns_ : release_ns_)
{
    equations_.is_held = close_ns_ == 0;
    state_ = equations_.at_rest<beam_state>(reference_m);
    solver_ = make_solver(rig_, equations_);
}

void gripped_plant::advance(const reference_line &line, std::int64_t now_ns, std::int64_t duration_ns)
{
    const std::int64_t end_ns = now_ns + duration_ns;
    reference_line here = line;
    while (next_change_ns_ < end_ns) {
        const std::int64_t before_ns = std::max<std::int64_t>(0, next_change_ns_ - now_ns);
        if (before_ns > 0) {
            solver_->advance(state_, here, before_ns);
            now_ns += before_ns;
            here.position_m += here.velocity_m_per_s * static_cast<double>(before_ns) * 1e-9;
        }
        change_grip(here, now_ns);
    }
    solver_->advance(state_, here, end_ns - now_ns);
}

/* The gripper closes where robot and object are: nothing is strained at first. */
void gripped_plant::change_grip(const reference_line &line, std::int64_t now_ns)
{
    equations_.is_held = now_ns < release_ns_;
    if (equations_.is_held) {
        equations_.grip_m = robot_position_m(line) - state_(object_position);
    }
    next_change_ns_ = equations_.is_held ? release_ns_ : event_ns(never);
    solver_ = make_solver(rig_, equations_);
}

} // namespace berth
