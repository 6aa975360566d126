#include "limits.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <functional>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/effect.h"
#include "critical_zero.h"
#include "dominant_root.h"
#include "first_order_limit.h"

namespace berth
{

namespace
{

/* Bisection ends here: relative, far below the 6 digits that are told. */
constexpr double bisection_tolerance = 1e-11;

/* |z| just beyond a limit is 1 but for the width of the bisection's last bracket, unless it jumps. */
constexpr double jump_least = 1e-6;

/* Dead time alone turns the loop over at half a period of a mode: up to here it is what swings without dead time. */
constexpr double slow_mode_periods = 1.0 / 3.0;

enum class scale { mass, stiffness, damping, ratio, frequency, delay };

struct physical_parameter {
    std::string_view key;
    scale kind;
};

constexpr physical_parameter parameters[] = {
    {"manipulator.mass_kg", scale::mass},
    {"manipulator.stiffness_N_per_m", scale::stiffness},
    {"manipulator.damping_N_s_per_m", scale::damping},
    {"object.mass_kg", scale::mass},
    {"object.stiffness_N_per_m", scale::stiffness},
    {"object.damping_N_s_per_m", scale::damping},
    {"robot.dead_time_ms", scale::delay},
    {"robot.transfer_frequency_Hz", scale::frequency},
    {"robot.transfer_damping_ratio", scale::ratio},
    {"robot.lag_ms", scale::delay},
    {"sensor.stiffness_N_per_m", scale::stiffness},
    {"sensor.damping_ratio", scale::ratio},
    {"sensor.low_pass_frequency_Hz", scale::frequency},
    {"sensor.low_pass_damping_ratio", scale::ratio},
    {"sensor.delay_ms", scale::delay},
    {"sensor.lag_ms", scale::delay},
    {"object.second_mass_kg", scale::mass},
    {"object.second_frequency_Hz", scale::frequency},
    {"object.second_damping_ratio", scale::ratio},
};

scale scale_of(std::string_view key)
{
    const auto found = std::find_if(std::begin(parameters), std::end(parameters),
                                    [&](const physical_parameter &p) { return p.key == key; });
    if (found == std::end(parameters)) {
        throw input_error(std::string(key) + ": is no physical parameter with a limit");
    }
    return found->kind;
}

/* The rig with another value of one parameter; nothing where a rig file may not have it. */
std::optional<rig> with_value(const rig &original, const rig_key &key, double value)
{
    rig changed = original;
    *static_cast<double *>(key.member(changed)) = value;
    const bool in_range = value > key.low || (key.low_is_allowed && value == key.low);
    if (!in_range || complete_and_check(changed)) {
        return {};
    }
    return changed;
}

/* Not so where a spring softens so far that a period of its motion overflows. */
bool is_finite(const loop_equation &equation)
{
    const equation_value f = evaluate(equation, 0.5);
    return std::isfinite(f.value.real()) && std::isfinite(f.slope.real());
}

bool is_stable_loop(const rig &rig, const linear_view &linear)
{
    const loop_equation equation = make_loop_equation(linear(rig));
    return is_finite(equation) && has_no_zero_inside(equation, 1.0);
}

/* A size to search around where the rig's own value is 0. */
double usual_value(const rig &rig, scale kind)
{
    const manipulator_config &m = rig.firmware.manipulator;
    const double stiffness = std::max({m.stiffness_N_per_m, rig.object.stiffness_N_per_m, 1.0});
    switch (kind) {
    case scale::stiffness:
        return stiffness;
    case scale::damping:
        return 0.1 * std::sqrt(stiffness * (m.mass_kg + rig.object.mass_kg));
    case scale::ratio:
        return 0.1;
    case scale::delay:
        return 1e3 * config_period_s(&rig.firmware);
    case scale::mass:
    case scale::frequency:
        break;
    }
    return 1.0;
}

/* Halves [good, bad] until it is as narrow as rounding lets it be; both ends keep what `is_good` says of them. */
void bisect(double &good, double &bad, const std::function<bool(double)> &is_good)
{
    const double narrow = bisection_tolerance * std::max(std::abs(good), std::abs(bad));
    while (std::abs(bad - good) > narrow) {
        const double middle = 0.5 * (good + bad);
        if (middle == good || middle == bad) {
            return;
        }
        (is_good(middle) ? good : bad) = middle;
    }
}

/* Along a delay the eigenvalues swing once a period of the loop: no step is longer than a part of it. */
double longest_step(const rig &rig, scale kind, double range)
{
    constexpr double steps_a_period = 20.0;
    constexpr double steps_max = 200000.0;
    return kind == scale::delay ? std::max(1e3 * config_period_s(&rig.firmware) / steps_a_period, range / steps_max)
                                : unlimited;
}

/* Values to look at, rising: a logarithmic grid, finer for delays, the permitted smallest value, and the rig's own.
 */
std::vector<double> scan_grid(const rig &rig, const rig_key &key, scale kind, double own, double share)
{
    const auto is_permitted = [&](double value) { return with_value(rig, key, value).has_value(); };
    const double centre = own > 0.0 ? own : usual_value(rig, kind);
    const double factor = kind == scale::delay ? 10.0 : 1e3;
    double low = centre / factor;
    if (key.low_is_allowed && is_permitted(0.0)) {
        low = 0.0;
    } else if (!is_permitted(low)) {
        double permitted = own;
        bisect(permitted, low, is_permitted);
        low = permitted;
    }
    const double step_max = longest_step(rig, kind, centre * factor);
    std::vector<double> grid{low};
    double value = low > 0.0 ? low * (1.0 + share) : centre / factor;
    while (value < centre * factor) {
        grid.push_back(value);
        value += std::min(share * value, step_max);
    }
    grid.push_back(centre * factor);
    grid.push_back(own);
    std::sort(grid.begin(), grid.end());
    grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
    return grid;
}

/* A change of sign: between these neighbours, which are as near as bisection gets. */
struct crossing {
    double stable;
    double unstable;

    double value() const { return 0.5 * (stable + unstable); }
};

std::vector<crossing> find_crossings(const std::vector<double> &grid, const std::function<bool(double)> &is_stable)
{
    std::vector<crossing> found;
    bool before = is_stable(grid.front());
    for (std::size_t i = 1; i < grid.size(); i++) {
        const bool here = is_stable(grid[i]);
        if (here != before) {
            crossing c = here ? crossing{grid[i], grid[i - 1]} : crossing{grid[i - 1], grid[i]};
            bisect(c.stable, c.unstable, is_stable);
            found.push_back(c);
        }
        before = here;
    }
    return found;
}

/* `ends` of stable intervals within the grid, by rising value. */
std::vector<stable_interval> intervals_between(const std::vector<double> &grid, bool starts_stable,
                                               std::vector<double> ends)
{
    if (starts_stable) {
        ends.insert(ends.begin(), grid.front());
    }
    if (ends.size() % 2 == 1) {
        ends.push_back(grid.back());
    }
    std::vector<stable_interval> intervals;
    for (std::size_t i = 0; i < ends.size(); i += 2) {
        intervals.push_back({ends[i], ends[i + 1]});
    }
    return intervals;
}

std::string name_of(const mode &mode, const rig &rig)
{
    const double half_rate_Hz = 0.5 / config_period_s(&rig.firmware);
    const double periods = mode.frequency_Hz * loop_delay_s(rig);
    if (mode.frequency_Hz == 0.0) {
        return "drift without oscillation";
    }
    if (mode.frequency_Hz >= half_rate_Hz * (1.0 - 1e-9)) {
        return "fast mode: alternates from tick to tick";
    }
    if (periods < slow_mode_periods) {
        return "slow mode: manipulator and object together";
    }
    char text[80];
    std::snprintf(text, sizeof text, "dead-time mode: %.2f periods of it fit into the loop's delay", periods);
    return text;
}

/* Counting zeros in the unit circle does not tell 1e-9 from nothing; the zero itself does: |w| = 1, by secants. */
double refined(const crossing &c, std::complex<double> w, const std::function<loop_equation(double)> &equation_at)
{
    double before = c.value();
    double value = before + std::max(std::abs(before) * 1e-5, 2e-5); /* delays have steps of 1e-6 ms */
    double radius_before = std::abs(zero_near(equation_at(before), w));
    for (int i = 0; i < 6; i++) {
        w = zero_near(equation_at(value), w);
        const double slope = (std::abs(w) - radius_before) / (value - before);
        radius_before = std::abs(w);
        before = value;
        value -= (radius_before - 1.0) / slope;
        if (!(std::abs(value - c.value()) < 1e-2 * c.value())) {
            return c.value();
        }
        if (std::abs(value - before) < 1e-9 * value) {
            break;
        }
    }
    return value;
}

stability_limit describe(const crossing &c, const rig &original, const rig_key &key, const linear_view &linear)
{
    const rig beyond = linear(*with_value(original, key, c.unstable));
    const loop_equation equation = make_loop_equation(beyond);
    if (!is_finite(equation)) {
        return {c.value(), c.stable > c.unstable, false, {}, "no linear loop: a spring softens to nothing"};
    }
    const std::complex<double> w = zero_next_to_unit_circle(equation);
    const mode mode = mode_of(1.0 / w, config_period_s(&beyond.firmware));
    stability_limit limit{c.value(), c.stable > c.unstable, std::abs(mode.z) > 1.0 + jump_least, mode,
                          name_of(mode, beyond)};
    if (limit.is_jump) {
        return limit;
    }
    const double value = refined(c, w, [&](double at) {
        const auto changed = with_value(original, key, at);
        return make_loop_equation(changed ? linear(*changed) : beyond);
    });
    /* The zero may have led to a place where it is not the one that decides. */
    const auto is_stable_at = [&](double at) {
        const auto changed = with_value(original, key, at);
        return changed && is_stable_loop(*changed, linear);
    };
    const double aside = std::max(1e-6 * std::abs(value), 2e-6); /* delays have steps of 1e-6 ms */
    const double up = limit.stable_above ? aside : -aside;
    if (is_stable_at(value + up) && !is_stable_at(value - up)) {
        limit.value = value;
    }
    return limit;
}

template <typename T, typename Value>
const T *nearest(const std::vector<T> &rising, double own, bool above, Value value_of)
{
    const T *found = nullptr;
    for (const T &candidate : rising) {
        if (above && value_of(candidate) >= own) {
            return &candidate;
        }
        if (!above && value_of(candidate) <= own) {
            found = &candidate;
        }
    }
    return found;
}

std::optional<double> value_at(const double *value)
{
    return value != nullptr ? std::optional<double>(*value) : std::nullopt;
}

constexpr auto limit_value = [](const stability_limit &limit) { return limit.value; };
constexpr auto itself = [](double value) { return value; };

} // namespace

const stability_limit *parameter_limits::nearest_below() const
{
    return nearest(limits, value, false, limit_value);
}

const stability_limit *parameter_limits::nearest_above() const
{
    return nearest(limits, value, true, limit_value);
}

std::optional<double> parameter_limits::first_order_below() const
{
    return value_at(nearest(first_order_limits, value, false, itself));
}

std::optional<double> parameter_limits::first_order_above() const
{
    return value_at(nearest(first_order_limits, value, true, itself));
}

std::vector<std::string_view> physical_parameters(const rig &rig)
{
    std::vector<std::string_view> keys;
    for (const physical_parameter &parameter : parameters) {
        const std::string_view key = parameter.key;
        const bool is_absent = (key.find("robot.transfer") == 0 && !rig.has_transfer_behaviour()) ||
                               ((key == "robot.lag_ms" || key == "sensor.lag_ms") && value_of(rig, key) == 0.0) ||
                               (key.find("object.second") == 0 && value_of(rig, "object.second_mass_kg") == 0.0) ||
                               (key == "sensor.low_pass_frequency_Hz" && rig.sensor.low_pass_order == 0) ||
                               (key == "sensor.low_pass_damping_ratio" && rig.sensor.low_pass_order < 2);
        if (!is_absent) {
            keys.push_back(key);
        }
    }
    return keys;
}

parameter_limits find_limits(const rig &original, std::string_view key_path, const linear_view &linear, double share)
{
    const scale kind = scale_of(key_path);
    const rig_key &key = *find_key(key_path);
    rig copy = original;
    const double own = *static_cast<double *>(key.member(copy));
    const std::vector<double> grid = scan_grid(original, key, kind, own, share);

    const auto is_stable = [&](double value) {
        const auto changed = with_value(original, key, value);
        return changed && is_stable_loop(*changed, linear);
    };
    const auto is_stable_to_first_order = [&](double value) {
        const auto changed = with_value(original, key, value);
        return changed && first_order_damping_margin(*changed) > 0.0;
    };

    parameter_limits result{key.path, own, grid.front(), grid.back(), {}, {}, {}};
    for (const crossing &c : find_crossings(grid, is_stable)) {
        result.limits.push_back(describe(c, original, key, linear));
    }
    std::vector<double> ends;
    for (const stability_limit &limit : result.limits) {
        ends.push_back(limit.value);
    }
    const bool starts_stable = result.limits.empty() ? is_stable(own) : !result.limits.front().stable_above;
    result.stable = intervals_between(grid, starts_stable, std::move(ends));
    for (const crossing &c : find_crossings(grid, is_stable_to_first_order)) {
        result.first_order_limits.push_back(c.value());
    }
    return result;
}

std::vector<stable_interval> stable_within(const rig &original, std::string_view key_path, double from, double to,
                                           const linear_view &linear)
{
    const rig_key &key = *find_key(key_path);
    const auto is_stable = [&](double value) {
        const auto changed = with_value(original, key, value);
        return changed && is_stable_loop(*changed, linear);
    };
    const double step_max = std::min(scan_step * to, longest_step(original, scale_of(key_path), to - from));
    const auto steps = static_cast<int>(std::ceil((to - from) / step_max));
    std::vector<double> grid;
    for (int i = 0; i <= steps; i++) {
        grid.push_back(i < steps ? from + (to - from) * i / steps : to);
    }
    std::vector<double> ends;
    for (const crossing &c : find_crossings(grid, is_stable)) {
        ends.push_back(c.value());
    }
    return intervals_between(grid, is_stable(from), ends);
}

std::optional<double> dead_time_margin_ms(const rig &rig, const parameter_limits &dead_time,
                                          const linear_view &linear)
{
    const stability_limit *const limit = dead_time.nearest_above();
    if (limit == nullptr || !is_stable_loop(rig, linear)) {
        return {};
    }
    return limit->value - dead_time.value;
}

std::vector<rate_verdict> judge_rates(const rig &original, const linear_view &linear)
{
    std::vector<double> rates_Hz{10,  20,  25,  40,   50,   80,   100,  125,  160,  200,  250,  320,  400,
                                 500, 625, 800, 1000, 1250, 1600, 2000, 2500, 3125, 4000, 5000, 8000, 10000};
    rates_Hz.push_back(original.firmware.loop.rate_Hz);
    std::sort(rates_Hz.begin(), rates_Hz.end());
    rates_Hz.erase(std::unique(rates_Hz.begin(), rates_Hz.end()), rates_Hz.end());

    std::vector<rate_verdict> verdicts;
    for (const double rate_Hz : rates_Hz) {
        rig changed = original;
        changed.firmware.loop.rate_Hz = rate_Hz;
        rate_verdict verdict{rate_Hz, ""};
        if (const auto error = complete_and_check(changed)) {
            verdict.refusal = error->key + ": " + error->message;
        } else {
            verdict.is_stable = is_stable_loop(changed, linear);
        }
        verdicts.push_back(verdict);
    }
    return verdicts;
}

} // namespace berth
