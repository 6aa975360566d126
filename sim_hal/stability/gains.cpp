#include "gains.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "../../hal/rig/keys.h"
#include "../effects/effect.h"
#include "dominant_root.h"
#include "hardware_period.h"
#include "modulus_margin.h"
#include "physical_parameter.h"

namespace berth
{

namespace
{

constexpr std::string_view rate_key = "loop.rate_Hz";

/* The nearest rate whose period is a whole number of nanoseconds, as that of the samples in it, and one that object
 * 0x60C2 can tell a drive. */
double possible_rate_Hz(double rate_Hz, const rig &rig)
{
    const app_config &config = rig.firmware;
    const std::int64_t samples_a_tick = config_period_ns(&config) / config_sample_period_ns(&config);
    double step_ns = static_cast<double>(std::max<std::int64_t>(1, samples_a_tick));
    while (config.robot_channel.profile == ROBOT_PROFILE_CIA402 && std::round(1e9 / rate_Hz / step_ns) > UINT8_MAX) {
        step_ns *= 10.0;
    }
    return 1e9 / (step_ns * std::round(1e9 / rate_Hz / step_ns));
}

std::optional<changed_loop> changed_to(const rig &original, std::string_view path, double value, delays_stay delays,
                                       const linear_view &linear)
{
    const rig start = path == rate_key ? at_rate(original, value, delays) : original;
    const auto changed = with_value(start, *find_key(path), value);
    if (!changed) {
        return {};
    }
    auto quality = quality_of(linear(*changed));
    return quality ? std::optional<changed_loop>({value, *quality}) : std::nullopt;
}

parameter_gain gain_of(const rig &original, std::string_view path, double share, delays_stay delays,
                       const linear_view &linear)
{
    const double own = value_of(original, path);
    const bool is_rate = path == rate_key;
    const double step = share * (own != 0.0 ? own : usual_value(original, scale_of(path)));
    const auto value_at = [&](double value) { return is_rate ? possible_rate_Hz(value, original) : value; };
    return {find_key(path)->path, own, delays, changed_to(original, path, value_at(own - step), delays, linear),
            changed_to(original, path, value_at(own + step), delays, linear)};
}

constexpr double none = -std::numeric_limits<double>::infinity();

double decay_per_s(const changed_loop *changed)
{
    return changed != nullptr ? -changed->quality.mode.growth_per_s : none;
}

double margin(const changed_loop *changed)
{
    return changed != nullptr ? changed->quality.margin.value_or(none) : none;
}

const changed_loop *better(const parameter_gain &gain, double (*measure)(const changed_loop *))
{
    const changed_loop *const less = gain.less ? &*gain.less : nullptr;
    const changed_loop *const more = gain.more ? &*gain.more : nullptr;
    const changed_loop *const found = measure(less) > measure(more) ? less : more;
    return measure(found) > none ? found : nullptr;
}

} // namespace

std::optional<loop_quality> quality_of(const rig &rig)
{
    const loop_equation equation = make_loop_equation(rig);
    if (!is_finite(equation)) {
        return {};
    }
    dominant_root_finder finder;
    const double radius = finder.spectral_radius(equation);
    const mode mode = mode_of(finder.dominant_eigenvalue(), config_period_s(&rig.firmware));
    return {{mode, mode_name(mode, rig),
             radius < 1.0 ? std::optional<double>(modulus_margin(equation)) : std::nullopt,
             hardware_period(rig).sample_age_ticks()}};
}

const changed_loop *parameter_gain::decaying_faster() const
{
    return better(*this, decay_per_s);
}

const changed_loop *parameter_gain::with_more_margin() const
{
    return better(*this, margin);
}

std::vector<parameter_gain> find_gains(const rig &rig, double share, const linear_view &linear)
{
    std::vector<parameter_gain> gains;
    for (const delays_stay delays : {delays_stay::in_ms, delays_stay::in_ticks}) {
        gains.push_back(gain_of(rig, rate_key, share, delays, linear));
    }
    for (const std::string_view key : physical_parameters(rig)) {
        gains.push_back(gain_of(rig, key, share, delays_stay::in_ms, linear));
    }
    return gains;
}

void rank_by_decay(std::vector<parameter_gain> &gains)
{
    std::stable_sort(gains.begin(), gains.end(), [](const parameter_gain &a, const parameter_gain &b) {
        return decay_per_s(a.decaying_faster()) > decay_per_s(b.decaying_faster());
    });
}

void rank_by_margin(std::vector<parameter_gain> &gains)
{
    std::stable_sort(gains.begin(), gains.end(), [](const parameter_gain &a, const parameter_gain &b) {
        return margin(a.with_more_margin()) > margin(b.with_more_margin());
    });
}

} // namespace berth
