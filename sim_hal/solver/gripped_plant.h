/* The plant from instant to instant, with a gripper that closes on the object and lets it go: at both instants,
 * known beforehand, integration stops, and starts again with other equations. */
#ifndef SIM_HAL_SOLVER_GRIPPED_PLANT_H
#define SIM_HAL_SOLVER_GRIPPED_PLANT_H

#include "solver.h"

namespace berth
{

class gripped_plant
{
  public:
    /* At rest with the reference at `reference_m`. */
    gripped_plant(const rig &rig, double reference_m);

    /* Advances from `now_ns` by `duration_ns`; `line` is the reference, its position that at `now_ns`. What happens
     * to the grip at an instant happens last of all there: a sample taken at it knows nothing of it. */
    void advance(const reference_line &line, std::int64_t now_ns, std::int64_t duration_ns);

    /* The reference jumps by `jump_m`. */
    void jump(double jump_m) { equations_.apply_reference_jump(state_, jump_m); }

    /* As they are now. */
    const plant &equations() const { return equations_; }
    const beam_state &state() const { return state_; }
    void set_state(const beam_state &state) { state_ = state; }

    double robot_position_m(const reference_line &line) const { return equations_.robot_position_m(state_, line); }
    double measured_force_N(const reference_line &line) const { return equations_.measured_force_N(state_, line); }

  private:
    void change_grip(const reference_line &line, std::int64_t now_ns);

    berth::rig rig_;
    plant equations_;
    std::int64_t close_ns_; /* 0: gripped from the start */
    std::int64_t release_ns_;
    std::int64_t next_change_ns_;
    beam_state state_;
    std::unique_ptr<berth::solver> solver_;
};

} // namespace berth

#endif
