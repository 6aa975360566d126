#include "flight_limits.h"

#include <algorithm>

#include "stability/spectrum.h"
#include "stability/tool_loops.h"

namespace berth
{

namespace
{

std::vector<stable_interval> common_parts(const std::vector<stable_interval> &a,
                                          const std::vector<stable_interval> &b)
{
    std::vector<stable_interval> parts;
    for (const stable_interval &one : a) {
        for (const stable_interval &other : b) {
            const stable_interval part{std::max(one.from, other.from), std::min(one.to, other.to)};
            if (part.from < part.to) {
                parts.push_back(part);
            }
        }
    }
    return parts;
}

/* The object's spring and damper are not felt there. */
bool is_felt_in_flight(std::string_view key)
{
    return key != "object.stiffness_N_per_m" && key != "object.damping_N_s_per_m";
}

} // namespace

void cut_by_flight(parameter_limits &limits, const rig &rig, const scan &how)
{
    if (rig.object.kind != object_kind::contact || rig.firmware.arm.kind != ARM_NONE) {
        return;
    }
    const berth::rig flight = in_free_flight(rig);
    if (drifts_freely(flight)) {
        return;
    }
    if (!is_felt_in_flight(limits.key)) {
        if (spectral_radius_of(flight) >= 1.0) {
            limits.stable.clear();
            limits.limits.clear();
        }
        return;
    }
    const parameter_limits in_flight = find_limits(flight, limits.key, as_it_is, how);
    std::vector<stability_limit> all = limits.limits;
    for (stability_limit limit : in_flight.limits) {
        limit.mode_name += ", of the tool in free flight";
        all.push_back(limit);
    }
    limits.stable = common_parts(limits.stable, in_flight.stable);
    limits.limits.clear();
    for (const stability_limit &limit : all) {
        const bool is_end =
            std::any_of(limits.stable.begin(), limits.stable.end(), [&](const stable_interval &part) {
                return (limit.stable_above ? part.from : part.to) == limit.value;
            });
        if (is_end) {
            limits.limits.push_back(limit);
        }
    }
    std::sort(limits.limits.begin(), limits.limits.end(),
              [](const stability_limit &a, const stability_limit &b) { return a.value < b.value; });
}

} // namespace berth
