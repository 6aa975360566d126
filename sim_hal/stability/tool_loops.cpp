#include "tool_loops.h"

namespace berth
{

rig in_contact(const rig &rig)
{
    berth::rig held = rig;
    if (held.object.kind == object_kind::contact) {
        held.object.kind = object_kind::gripped;
    }
    return held;
}

rig in_free_flight(const rig &rig)
{
    berth::rig free = in_contact(rig);
    free.object.stiffness_N_per_m = 0.0;
    free.object.damping_N_s_per_m = 0.0;
    /* The firmware's model of the tool knows where the surface is, too. */
    free.firmware.hardware.stiffness_N_per_m = 0.0;
    free.firmware.hardware.damping_N_s_per_m = 0.0;
    return free;
}

} // namespace berth
