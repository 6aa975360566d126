#include "virtual_rig.h"

namespace berth
{

virtual_rig::virtual_rig(const rig &rig)
    : hardware_{plant(rig), make_solver(rig), plant(rig).at_rest(rig.firmware.manipulator.initial_position_m)},
      events_(rig)
{
}

rig_truth virtual_rig::truth() const
{
    const plant &equations = hardware_.equations;
    const plant_state &state = hardware_.state;
    const reference_line line = events_.robot().line(now_ns());
    return {equations.robot_position_m(state, line),
            equations.robot_velocity_m_per_s(state, line),
            state(object_position),
            state(object_velocity),
            equations.spring_force_N(state, line),
            equations.measured_force_N(state, line)};
}

} // namespace berth
