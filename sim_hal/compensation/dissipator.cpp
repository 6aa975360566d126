#include "dissipator.h"

#include <cmath>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "../stability/spectrum.h"

namespace berth
{

namespace
{

/* From a damping ratio of the manipulator with its object of 1e-4 up to one of 100, by steps of 10 %. */
constexpr double lowest_ratio = 1e-4;
constexpr double highest_ratio = 100.0;
constexpr double grid_step = 1.1;
constexpr double accuracy = 1e-3;

rig with_margin(rig changed, const loop_margin &margin)
{
    changed.robot.dead_time_ms += margin.dead_time_ms;
    const rig_key *const gain = find_key("sensor.gain_error");
    double &error = changed.effect_values[gain->effect_value];
    error = (1.0 + error) * std::pow(10.0, margin.gain_dB / 20.0) - 1.0;
    if (const auto wrong = complete_and_check(changed)) {
        throw input_error(wrong->key + " " + wrong->message + ", with the margin");
    }
    return changed;
}

/* No such loop may be: neither. */
bool is_stable(rig at, double damping_N_s_per_m)
{
    at.firmware.dissipation.damping_N_s_per_m = damping_N_s_per_m;
    return !complete_and_check(at) && spectral_radius_of(at) < 1.0;
}

} // namespace

std::optional<double> least_damping(const rig &rig, const loop_margin &margin)
{
    const berth::rig worse = with_margin(rig, margin);
    if (is_stable(worse, 0.0)) {
        return 0.0;
    }
    const manipulator_config &arm = rig.firmware.manipulator;
    const double mass_kg = arm.mass_kg + rig.object.mass_kg;
    const double stiffness = arm.stiffness_N_per_m + rig.object.stiffness_N_per_m;
    const double unit = 2.0 * std::sqrt(mass_kg * (stiffness > 0.0 ? stiffness : mass_kg));
    double above = lowest_ratio * unit;
    while (above < highest_ratio * unit && !is_stable(worse, above)) {
        above *= grid_step;
    }
    if (!is_stable(worse, above)) {
        return {};
    }
    double below = above / grid_step;
    while (above / below > 1.0 + accuracy) {
        const double middle = std::sqrt(above * below);
        (is_stable(worse, middle) ? above : below) = middle;
    }
    return above;
}

} // namespace berth
