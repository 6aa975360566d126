#include "assumptions.h"

#include "../hal/rig/given.h"
#include "../hal/rig/keys.h"

namespace berth
{

std::vector<assumption> assumptions_of(const rig &rig)
{
    const bool has_arm = rig.firmware.arm.kind != ARM_NONE;
    const bool touches = !touches_nothing(rig);
    const bool is_beam = rig.object.kind == object_kind::beam; /* its spring and damper follow from it */
    const struct {
        const char *key;
        bool counts;
    } decisive[] = {
        {"loop.rate_Hz", true},
        {"manipulator.stiffness_N_per_m", !has_arm},
        {"manipulator.damping_N_s_per_m", !has_arm},
        {"robot.interpolation", true},
        {"sensor.stiffness_N_per_m", touches},
        {"sensor.damping_ratio", touches},
        {"sensor.low_pass_order", touches},
        {"sensor.low_pass_frequency_Hz", touches && rig.sensor.low_pass_order > 0},
        {"sensor.low_pass_damping_ratio", touches && rig.sensor.low_pass_order == 2},
        {"sensor.delay_ms", touches},
        {"object.kind", true},
        {"object.stiffness_N_per_m", touches && !is_beam},
        {"object.damping_N_s_per_m", touches && !is_beam},
        {"object.surface_position_m", rig.object.kind == object_kind::contact},
        {"sensor_channel.force_limit_N", touches},
        {"limits.position_min_m", true},
        {"limits.position_max_m", true},
        {"limits.velocity_m_per_s", true},
        {"limits.acceleration_m_per_s2", true},
    };
    std::vector<assumption> found;
    for (const auto &one : decisive) {
        if (one.counts && !is_given(rig, one.key)) {
            const rig_key &key = *find_key(one.key);
            found.push_back({key.path, value_text(rig, key)});
        }
    }
    return found;
}

} // namespace berth
