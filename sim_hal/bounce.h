/* What one bounce of a tool does: the loop itself plays it, in virtual time, without noise, losses and limits.
 * Between touch and leave everything is linear, so that restitution does not depend on the speed of approach as long
 * as the manipulator's spring is relaxed at the surface, as it is here.
 *
 * Without a spring of its own, small delays and no low-pass it is exp(-pi z / sqrt(1 - z^2)) with
 * z = zeta - w0 tau / 2 (Li et al., J. Aerosp. Eng. 2026), tests/theory/restitution_test.cpp. */
#ifndef SIM_HAL_BOUNCE_H
#define SIM_HAL_BOUNCE_H

#include <optional>
#include <string_view>

#include "../hal/rig/rig.h"

namespace berth
{

struct played_bounce {
    double restitution;      /* speed after over speed before; 0: it does not come off again */
    double speed_in_m_per_s; /* at the surface */
    double contact_s;        /* in which the material pushes */
    double energy_share() const { return restitution * restitution - 1.0; } /* gained, of the energy before */
};

/* Of a rig with object.kind = "contact" and a manipulator of one degree of freedom; nothing where the tool never
 * reaches the surface, is stopped in the material, or takes longer than 20000 ticks, and than 10 s, to it or in it.
 * Throws input_error. */
std::optional<played_bounce> play_bounce(const rig &rig);

/* Whether the rig's own run brings the tool to the surface: without noise, but for an arm. Throws input_error. */
bool comes_to_surface(const rig &rig);

/* The value of a parameter nearest to the rig's own at which a bounce starts, or ends, to gain energy, within a
 * factor of 1000 (delays: 10) either way; nothing: there is none. Relative accuracy 1e-4. */
struct bounce_limit {
    double value;
    bool gains_above;
};
std::optional<bounce_limit> find_bounce_limit(const rig &rig, std::string_view key);

} // namespace berth

#endif
