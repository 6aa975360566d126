#include "virtual_rig.h"

#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"

namespace berth
{

virtual_rig::virtual_rig(const rig &rig)
    : events_(rig), hardware_{gripped_plant(rig, events_.robot().line(0).position_m), {}}
{
    if (has_hardware_effects(rig)) {
        if (rig.object.further_mode_count > 0) {
            throw input_error("object.modes: a beam of several modes knows no effects beside it: leave out " +
                              effect_names(rig, is_hardware_effect) + ", or set object.modes = 1");
        }
        hardware_.effects = std::make_unique<effect_solver>(rig, events_.robot().line(0).position_m);
    }
}

void virtual_rig::set_state(const beam_state &state)
{
    hardware_.base.set_state(state);
    if (hardware_.effects) {
        hardware_.effects->set_state(state);
    }
}

rig_truth virtual_rig::truth() const
{
    if (hardware_.effects) {
        const effect_solver &effects = *hardware_.effects;
        const beam_state state = effects.state();
        return {state(robot_position),  state(robot_velocity),    state(object_position),
                state(object_velocity), effects.spring_force_N(), effects.measured_force_N()};
    }
    const plant &equations = hardware_.base.equations();
    const beam_state &state = hardware_.base.state();
    const reference_line line = events_.robot().line(now_ns());
    return {equations.robot_position_m(state, line),
            equations.robot_velocity_m_per_s(state, line),
            state(object_position),
            state(object_velocity),
            equations.spring_force_N(state, line),
            equations.measured_force_N(state, line)};
}

} // namespace berth
