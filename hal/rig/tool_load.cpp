#include "tool_load.h"

#include <algorithm>

namespace berth
{

std::array<double, 6> tool_load(const tool_rig &tool)
{
    std::array<double, 3> force_N{};
    for (std::size_t i = 0; i < 3; i++) {
        force_N[i] = -tool.mass_kg * tool.gravity_m_per_s2[i];
    }
    const std::array<double, 3> &c = tool.centre_m;
    return {force_N[0],
            force_N[1],
            force_N[2],
            c[1] * force_N[2] - c[2] * force_N[1],
            c[2] * force_N[0] - c[0] * force_N[2],
            c[0] * force_N[1] - c[1] * force_N[0]};
}

tare_config tare_of(const rig &rig)
{
    tare_config tare{};
    const std::array<double, 6> load = tool_load(rig.tool);
    bool is_zero = true;
    for (std::size_t i = 0; i < 3; i++) {
        tare.force_N[i] = rig.tare.force_N[i] + load[i];
        tare.torque_N_m[i] = rig.tare.torque_N_m[i] + load[i + 3];
        is_zero = is_zero && tare.force_N[i] == 0.0 && tare.torque_N_m[i] == 0.0;
    }
    tare.enabled = rig.tare.enabled && !is_zero;
    return tare;
}

} // namespace berth
