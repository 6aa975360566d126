#include "compensated.h"

#include <cmath>

#include "../hal/rig/keys.h"
#include "compensation/measured_map.h"
#include "prediction.h"
#include "stability/compensation_states.h"
#include "stability/physical_parameter.h"
#include "stability/spectrum.h"

namespace berth
{

namespace
{

constexpr double furthest = 10.0;
constexpr int steps = 16;
constexpr double near_enough_exact = 1e-4;
constexpr double near_enough_measured = 5e-3; /* the growth of 20 s tells no more */

/* Another hardware under the same firmware; nothing where no rig may have it. */
std::optional<rig> with_hardware(const rig &original, const rig_key &key, double value)
{
    auto changed = with_value(original, key, value);
    if (changed) {
        changed->firmware = original.firmware;
    }
    return changed;
}

/* Nothing where no rig may have the value. */
std::optional<bool> is_stable_with(const rig &original, const rig_key &key, double value)
{
    const auto changed = with_hardware(original, key, value);
    return changed ? std::optional<bool>(growth_of_compensated(*changed).growth_per_s < 0.0) : std::nullopt;
}

/* From the rig's own value on by growing factors, up or down. */
std::optional<double> first_change(const rig &original, const rig_key &key, double own, bool is_stable, bool upwards,
                                   double near_enough)
{
    double inside = own;
    for (int i = 1; i <= steps; i++) {
        const double share = std::pow(furthest, static_cast<double>(i) / steps);
        double outside = upwards ? own * share : own / share;
        const auto found = is_stable_with(original, key, outside);
        if (!found) {
            return {};
        }
        if (*found == is_stable) {
            inside = outside;
            continue;
        }
        while (std::abs(std::log(outside / inside)) > near_enough) {
            const double middle = std::sqrt(inside * outside);
            const bool is_as_own = is_stable_with(original, key, middle).value_or(!is_stable) == is_stable;
            (is_as_own ? inside : outside) = middle;
        }
        return std::sqrt(inside * outside);
    }
    return {};
}

} // namespace

compensated_growth growth_of_compensated(const rig &rig)
{
    if (compensation_is_linear(rig)) {
        return {std::log(spectral_radius_of(in_contact(rig))) / config_period_s(&rig.firmware), false};
    }
    berth::rig quiet = released_rig(rig, 0.0);
    quiet.sensor.noise_N = quiet.robot.feedback_noise_m = 0.0;
    return {measure(quiet, compensated_run_s).growth_per_s, true};
}

std::vector<compensated_limit> limits_of_compensated(const rig &rig)
{
    const compensated_growth own = growth_of_compensated(rig);
    const double near_enough = own.is_measured ? near_enough_measured : near_enough_exact;
    std::vector<compensated_limit> found;
    for (const char *const path : {"robot.dead_time_ms", "object.mass_kg", "object.stiffness_N_per_m"}) {
        const rig_key &key = *find_key(path);
        berth::rig copy = rig;
        const double value = *static_cast<double *>(key.member(copy));
        if (value > 0.0) {
            const bool is_stable = own.growth_per_s < 0.0;
            found.push_back({key.path, value, first_change(rig, key, value, is_stable, false, near_enough),
                             first_change(rig, key, value, is_stable, true, near_enough)});
        }
    }
    return found;
}

} // namespace berth
