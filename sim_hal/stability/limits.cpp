#include "limits.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <functional>
#include <map>

#include "../../hal/rig/rig_file.h"
#include "critical_zero.h"
#include "dominant_root.h"
#include "first_order_limit.h"
#include "hardware_period.h"
#include "physical_parameter.h"
#include "scan_grid.h"
#include "stable_intervals.h"
#include "zero_count.h"

namespace berth
{

namespace
{

/* |z| just beyond a limit is 1 but for the width of the bisection's last bracket, unless it jumps. */
constexpr double jump_least = 1e-6;

bool is_stable_loop(const rig &rig)
{
    const loop_equation equation = make_loop_equation(rig);
    return is_finite(equation) && has_no_zero_inside(equation, 1.0);
}

/* The rigs along one parameter: which there are, and what becomes of them. Values are looked at several times. */
class parameter_line
{
  public:
    parameter_line(const rig &original, const rig_key &key, const linear_view &linear)
        : original_(original), key_(key), linear_(linear)
    {
    }

    /* Nothing: no rig may have the value, or it is like no linear loop. */
    std::optional<rig> linear_at(double value) const
    {
        const auto changed = with_value(original_, key_, value);
        if (!changed) {
            return {};
        }
        rig linear = linear_(*changed);
        return is_finite(make_loop_equation(linear)) ? std::optional<rig>(std::move(linear)) : std::nullopt;
    }
    bool exists(double value) { return look(value).exists; }
    bool is_stable(double value) { return look(value).is_stable; }
    bool is_stable_to_first_order(double value) { return look(value).is_stable_to_first_order; }

  private:
    struct verdict {
        bool exists = false;
        bool is_stable = false;
        bool is_stable_to_first_order = false;
    };

    const verdict &look(double value)
    {
        const auto known = verdicts_.find(value);
        if (known != verdicts_.end()) {
            return known->second;
        }
        verdict found;
        if (const auto linear = linear_at(value)) {
            found = {true, is_stable_loop(*linear), first_order_damping_margin(*linear) > 0.0};
        }
        return verdicts_.emplace(value, found).first->second;
    }

    const rig &original_;
    const rig_key &key_;
    const linear_view &linear_;
    std::map<double, verdict> verdicts_;
};

/* A change of sign: between these neighbours, which are as near as bisection gets. */
struct crossing {
    double stable;
    double unstable;

    double value() const { return 0.5 * (stable + unstable); }
};

/* The grid in pieces in which every value has a loop, up to the last value that has one. */
std::vector<std::vector<double>> parts_with_loops(const std::vector<double> &grid, parameter_line &line)
{
    const auto exists = [&](double value) { return line.exists(value); };
    std::vector<std::vector<double>> parts;
    bool before = false;
    for (std::size_t i = 0; i < grid.size(); i++) {
        const bool here = exists(grid[i]);
        if (here != before && i > 0) {
            double good = here ? grid[i] : grid[i - 1];
            double bad = here ? grid[i - 1] : grid[i];
            constexpr double near_enough = 1e-5; /* an end of the range, no limit */
            bisect(good, bad, exists, near_enough);
            if (here) {
                parts.push_back({good});
            } else if (good != parts.back().back()) {
                parts.back().push_back(good);
            }
        } else if (here && i == 0) {
            parts.emplace_back();
        }
        if (here && (parts.back().empty() || parts.back().back() != grid[i])) {
            parts.back().push_back(grid[i]);
        }
        before = here;
    }
    return parts;
}

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

/* Where |w| = 1, and by how much it changes with the value. */
struct refined_value {
    double value;
    double slope;
    bool is_near = true; /* to where counting sees it */
};

/* Counting zeros in the unit circle does not tell 1e-9 from nothing; the zero itself does: |w| = 1, with the slope
 * of a step that is wide against rounding. */
refined_value refined(const crossing &c, std::complex<double> w,
                      const std::function<loop_equation(double)> &equation_at)
{
    const double start = c.value();
    const double wide = std::max(std::abs(start) * 1e-5, 2e-5); /* delays have steps of 1e-6 ms */
    const auto radius_at = [&](double value) {
        w = zero_near(equation_at(value), w);
        return std::abs(w);
    };
    const double radius = radius_at(start);
    const double slope = (radius_at(start + wide) - radius) / wide;
    double value = start - (radius - 1.0) / slope;
    for (int i = 0; i < 4; i++) {
        if (!(std::abs(value - start) < 1e-2 * start)) {
            return {start, slope, false};
        }
        const double step = (radius_at(value) - 1.0) / slope;
        value -= step;
        if (std::abs(step) < 1e-8 * std::abs(value)) {
            break; /* delays are rounded to about as much */
        }
    }
    return {value, slope};
}

/* Why |z| jumps past 1. Where only the linear rig is looked at, nothing but the age of the force jumps. */
const char *reason_of_jump(const rig &stable, const rig &unstable, bool is_equivalent)
{
    return hardware_period(unstable).sample_age_ticks() > hardware_period(stable).sample_age_ticks()
               ? "the force becomes a tick older"
           : is_equivalent ? "at this amplitude another mode takes over"
                           : "rounding hides what is between";
}

/* Of the loop just on the unstable side of a limit: what goes is next to the circle, but where |z| jumps a stable
 * mode may be nearer. */
std::complex<double> zero_that_goes(const loop_equation &unstable)
{
    const std::complex<double> next = zero_next_to_unit_circle(unstable);
    if (std::abs(next) <= 1.0 + jump_least) {
        return next;
    }
    dominant_root_finder finder;
    finder.spectral_radius(unstable);
    return 1.0 / finder.dominant_eigenvalue();
}

stability_limit describe(const crossing &c, parameter_line &line, const scan &how)
{
    const auto unstable = line.linear_at(c.unstable);
    if (!unstable) { /* a gap between two values of the grid */
        return {c.value(), c.stable > c.unstable, "no rig beyond is like a linear loop", {}, "-"};
    }
    const rig &beyond = *unstable;
    const std::complex<double> w = zero_that_goes(make_loop_equation(beyond));
    const mode mode = mode_of(1.0 / w, config_period_s(&beyond.firmware));
    stability_limit limit{c.value(), c.stable > c.unstable, "", mode, mode_name(mode, beyond)};
    if (std::abs(mode.z) > 1.0 + jump_least) {
        limit.jump = reason_of_jump(*line.linear_at(c.stable), beyond, how.step > fine_scan.step);
        return limit;
    }
    const auto [value, slope, is_near] =
        refined(c, w, [&](double at) { return make_loop_equation(line.linear_at(at).value_or(beyond)); });
    if (!is_near) {
        limit.jump = "|z| is too near 1 all around to tell where it passes, a rough value";
        limit.is_rough = true;
        return limit;
    }
    /* The zero may have led to a place where it is not the one that decides. Counting sees it where it is a few of
     * its margins away from the circle; delays have steps of 1e-6 ms. */
    const double aside = std::max({1e-6 * std::abs(value), 2e-6, 4.0 * count_margin / std::abs(slope)});
    const double up = limit.stable_above ? aside : -aside;
    if (line.is_stable(value + up) && !line.is_stable(value - up)) {
        limit.value = value;
    }
    const double by = how.step > fine_scan.step ? 1e-5 * limit.value : 0.0;
    if (by > 0.0 && line.is_stable(limit.value + by) == line.is_stable(limit.value - by)) {
        limit.jump = "no frequency settles here, a rough value";
        limit.is_rough = true;
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

parameter_limits find_limits(const rig &original, std::string_view key_path, const linear_view &linear,
                             const scan &how)
{
    const parameter_scale kind = scale_of(key_path);
    const rig_key &key = *find_key(key_path);
    rig copy = original;
    const double own = *static_cast<double *>(key.member(copy));
    parameter_line line(original, key, linear);
    const auto is_stable = [&](double value) { return line.is_stable(value); };
    const auto is_stable_to_first_order = [&](double value) { return line.is_stable_to_first_order(value); };

    const auto parts = parts_with_loops(scan_grid(original, key, kind, own, how), line);
    if (parts.empty()) {
        throw input_error(std::string(key.path) +
                          ": no value of it makes a loop that can be looked at; another key of the "
                          "rig file is out of range");
    }
    parameter_limits result{key.path,
                            own,
                            parts.front().front(),
                            parts.back().back(),
                            {},
                            {},
                            {},
                            own > 0.0 ? own : usual_value(original, kind)};
    for (const std::vector<double> &part : parts) {
        std::vector<double> ends;
        for (const crossing &c : find_crossings(part, is_stable)) {
            result.limits.push_back(describe(c, line, how));
            ends.push_back(result.limits.back().value);
        }
        const bool starts_stable =
            ends.empty() ? is_stable(part.front()) : !result.limits[result.limits.size() - ends.size()].stable_above;
        const auto stable = intervals_between(part, starts_stable, std::move(ends));
        result.stable.insert(result.stable.end(), stable.begin(), stable.end());
        for (const crossing &c : find_crossings(part, is_stable_to_first_order)) {
            result.first_order_limits.push_back(c.value());
        }
    }
    result.stable = without_single_values(std::move(result.stable), own);
    return result;
}

std::vector<stable_interval> stable_within(const rig &original, std::string_view key_path, double from, double to,
                                           const linear_view &linear)
{
    const rig_key &key = *find_key(key_path);
    rig copy = original;
    const double own = *static_cast<double *>(key.member(copy));
    parameter_line line(original, key, linear);
    const auto is_stable = [&](double value) { return line.is_stable(value); };
    const double step_max =
        std::min(fine_scan.step * to, longest_step(original, scale_of(key_path), to - from, fine_scan));
    const auto steps = static_cast<int>(std::ceil((to - from) / step_max));
    std::vector<double> grid;
    for (int i = 0; i <= steps; i++) {
        grid.push_back(i < steps ? from + (to - from) * i / steps : to);
    }
    std::vector<stable_interval> intervals;
    for (const std::vector<double> &part : parts_with_loops(grid, line)) {
        std::vector<double> ends;
        for (const crossing &c : find_crossings(part, is_stable)) {
            ends.push_back(c.value());
        }
        const auto stable = intervals_between(part, is_stable(part.front()), std::move(ends));
        intervals.insert(intervals.end(), stable.begin(), stable.end());
    }
    return from < to ? without_single_values(std::move(intervals), own) : intervals;
}

std::optional<double> dead_time_margin_ms(const rig &rig, const parameter_limits &dead_time,
                                          const linear_view &linear)
{
    const stability_limit *const limit = dead_time.nearest_above();
    if (limit == nullptr || !is_stable_loop(linear(rig))) {
        return {};
    }
    return limit->value - dead_time.value;
}

std::vector<rate_verdict> judge_rates(const rig &original, delays_stay delays, const linear_view &linear)
{
    std::vector<double> rates_Hz{10,  20,  25,  40,   50,   80,   100,  125,  160,  200,  250,  320,  400,
                                 500, 625, 800, 1000, 1250, 1600, 2000, 2500, 3125, 4000, 5000, 8000, 10000};
    rates_Hz.push_back(original.firmware.loop.rate_Hz);
    std::sort(rates_Hz.begin(), rates_Hz.end());
    rates_Hz.erase(std::unique(rates_Hz.begin(), rates_Hz.end()), rates_Hz.end());

    std::vector<rate_verdict> verdicts;
    for (const double rate_Hz : rates_Hz) {
        rig changed = at_rate(original, rate_Hz, delays);
        rate_verdict verdict{rate_Hz, ""};
        if (const auto error = complete_and_check_steady(changed)) {
            verdict.refusal = error->key + ": " + error->message;
        } else {
            verdict.is_stable = is_stable_loop(linear(changed));
        }
        verdicts.push_back(verdict);
    }
    return verdicts;
}

} // namespace berth
