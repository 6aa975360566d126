#include <algorithm>

#include "effects.h"
#include "starts.h"

namespace berth
{

effect object_impact_damping()
{
    effect made;
    made.name = "object.impact_damping";
    made.physics = "Damping that grows with depth p: a contact force k p (1 + c p') instead of k p + d p'.";
    made.source = "Hunt & Crossley 1975";
    made.calibration = {30, "let the tool strike the material at some speeds, and record how fast it leaves"};
    made.parameters = {
        {"object.impact_damping_s_per_m", 0.0, 1e4, "c: contact force k p (1 + c p') instead of k p + d p'"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes_of(1.0 / std::max(1e-9, scales.velocity_m_per_s), {0.03, 0.1, 0.3, 1.0, 3.0, 10.0});
    };
    made.is_proportional = true;
    made.object = object_needed::contact;
    return made;
}

} // namespace berth
