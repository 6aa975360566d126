#include "verdict.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace berth
{

namespace
{

constexpr std::size_t least_heights = 8;

/* What moves little more than this share of its first half in its second has come to rest; in between, a slow growth
 * may be hidden in what the release has left. */
constexpr double comes_to_rest = 0.2;

/* The setpoint's step: less than that never comes to the robot. */
constexpr double stands_still_m = 1e-11;

double range(std::vector<double>::const_iterator from, std::vector<double>::const_iterator to)
{
    const auto [low, high] = std::minmax_element(from, to);
    return *high - *low;
}

/* What fell may level out and rise again, slowly: to its end it falls, or is at rest. */
bool falls_on(const std::vector<double> &signal, double at_first)
{
    constexpr double falls = 0.9;
    constexpr double at_rest = 0.02; /* of the height at first: noise */
    const auto eighth = static_cast<std::ptrdiff_t>(signal.size() / 8);
    const double before = range(signal.end() - 2 * eighth, signal.end() - eighth);
    const double last = range(signal.end() - eighth, signal.end());
    return last <= falls * before || last <= at_rest * at_first;
}

bool nothing_moved(const run_result &result)
{
    return result.running_m.empty() || range(result.running_m.begin(), result.running_m.end()) <= stands_still_m;
}

bool limits_acted_late(const run_result &result)
{
    return result.limited_until_sample > 3 * result.running_m.size() / 4;
}

double median_height(std::vector<oscillation_height>::const_iterator from,
                     std::vector<oscillation_height>::const_iterator to)
{
    std::vector<double> values;
    std::transform(from, to, std::back_inserter(values), [](const oscillation_height &h) { return h.value; });
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/* Limits bound the motion: does it fall nevertheless? While they act to the end, a fall is theirs, too. */
std::optional<bool> judge_limited(const run_result &result, double period_s)
{
    constexpr double falls = 0.9;
    constexpr double end = 0.9; /* of the run */
    const std::vector<oscillation_height> heights = oscillation_heights(result.running_m, period_s);
    if (heights.size() < least_heights) {
        return {};
    }
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    const bool is_lower = median_height(middle, heights.end()) < falls * median_height(heights.begin(), middle);
    const auto limited_until = static_cast<double>(result.limited_until_sample);
    if (is_lower && limited_until > end * static_cast<double>(result.running_m.size())) {
        return {};
    }
    return is_lower;
}

/* It did not swing often enough to tell growth from decay: it would have with more time. */
bool is_too_short(const run_result &result, double period_s, double half_swing_s)
{
    const std::vector<oscillation_height> heights = oscillation_heights(result.running_m, period_s);
    const std::size_t count = heights.size();
    const double seen_s = count >= 2 ? heights[count - 1].time_s - heights[count - 2].time_s : 0.0;
    const double duration_s = static_cast<double>(result.running_m.size()) * period_s;
    return count < least_heights && duration_s < least_heights * std::max(half_swing_s, seen_s);
}

/* Its interval holds 0. */
bool is_unclear(const growth_fit &growth)
{
    return !(std::abs(growth.growth_per_s) > growth.growth_ci95_per_s);
}

/* What has to be known beside a growth that was measured with motors at their torque limits: from there on they are
 * no springs any more. */
std::string motor_words(const run_result &result)
{
    if (result.longest.motor_limit_ticks == 0) {
        return "";
    }
    return "; motors were at their torque limit in " + std::to_string(result.longest.motor_limit_ticks) +
           " of its " + std::to_string(result.longest.tick.size()) +
           " ticks: the growth of a saturated loop says nothing of small motions";
}

/* Why there is no growth rate. */
std::string why_no_growth(const run_result &result, const rig &rig)
{
    const double period_s = config_period_s(&rig.firmware);
    const double left_s = period_s * static_cast<double>(result.left_in_tick);
    const double touched_s = period_s * static_cast<double>(result.held_ticks);
    if (result.limited_until_sample > 0) {
        return "limits bounded the motion: there is no growth rate to measure";
    }
    if (nothing_moved(result)) {
        return "nothing moved: there is no motion to judge";
    }
    if (rig.object.kind != object_kind::contact || left_s > 0.5 * result.simulated_s) {
        return "too little oscillation to measure a growth rate; a longer run (run.duration_s) may show more";
    }
    char text[200];
    std::snprintf(text, sizeof text,
                  "the tool touched the object for %.2f s, left it at %.2f s and did not come back: what is free "
                  "drifts, and no oscillation is left",
                  touched_s, left_s);
    return text;
}

} // namespace

std::optional<bool> judge(const run_result &result, double period_s, double half_swing_s)
{
    if (result.running_m.empty() || !result.was_gripped()) {
        return {};
    }
    if (result.cause == STOP_NOT_FINITE) {
        return false;
    }
    if (result.growth && !limits_acted_late(result)) {
        return is_unclear(*result.growth) ? std::nullopt : std::optional<bool>(result.growth->growth_per_s < 0.0);
    }
    if (result.growth && result.growth->growth_per_s > 0.0 && !is_unclear(*result.growth)) {
        return false;
    }
    if (limits_acted_late(result)) {
        return judge_limited(result, period_s);
    }
    if (result.cause != STOP_NONE && result.cause != STOP_REQUESTED) {
        return {};
    }
    if (nothing_moved(result)) {
        return {};
    }
    if (result.is_ordered) {
        return {}; /* how far it went was ordered */
    }
    if (is_too_short(result, period_s, half_swing_s)) {
        return {};
    }
    const auto middle = result.running_m.begin() + static_cast<std::ptrdiff_t>(result.running_m.size() / 2);
    const double first = range(result.running_m.begin(), middle);
    const double second = range(middle, result.running_m.end());
    if (second > first) {
        return false;
    }
    return second <= comes_to_rest * first && falls_on(result.running_m, first) ? std::optional<bool>(true)
                                                                                : std::nullopt;
}

void print_verdict(const run_result &result, const rig &rig)
{
    if (result.running_ticks == 0) {
        std::printf("  %-14s the supervisor never came to running%s\n", "NEVER RAN", result.obstacles.c_str());
        return;
    }
    if (!result.was_gripped()) {
        const double ran_s = config_period_s(&rig.firmware) * static_cast<double>(result.running_ticks);
        if (rig.object.kind == object_kind::contact) {
            std::printf(
                "  %-14s it ran for %.2f s, but the tool never came to the object: there was no loop to judge\n",
                "NEVER TOUCHED", ran_s);
        } else {
            std::printf(
                "  %-14s it ran for %.2f s, but never with the object gripped (run.grip_close_s = %g): there "
                "was no loop to judge\n",
                "NEVER GRIPPED", ran_s, rig.run.grip_close_s);
        }
        return;
    }
    const char *const verdict = !result.is_stable ? "NOT DETERMINED" : *result.is_stable ? "stable" : "DIVERGING";
    if (!result.growth) {
        std::printf("  %-14s %s%s\n", verdict, why_no_growth(result, rig).c_str(),
                    result.motors.any() ? "; motors were at their torque limit: this says nothing of small motions"
                                        : "");
        return;
    }
    const growth_fit &fit = *result.growth;
    const std::string beside = motor_words(result);
    if (fit.growth_per_s < 0.0 && result.is_stable == std::optional<bool>(false)) {
        std::printf(
            "  %-14s limits bounded the motion; where none acted it decayed by %.6f /s (+-%.1g) at %.4f Hz%s\n",
            verdict, -fit.growth_per_s, fit.growth_ci95_per_s, fit.frequency_Hz, beside.c_str());
        return;
    }
    const char *const does = fit.growth_per_s < 0.0 ? "decays" : "grows";
    if (!result.is_stable && is_unclear(fit)) {
        std::printf(
            "  %-14s the oscillation %s by %.6f /s (+-%.1g) at %.4f Hz, no more than its interval: the record "
            "does not tell decay from growth%s\n",
            verdict, does, std::abs(fit.growth_per_s), fit.growth_ci95_per_s, fit.frequency_Hz,
            beside.empty() ? "; a longer one may" : beside.c_str());
        return;
    }
    const double factor_time_s = std::log(2.0) / std::abs(fit.growth_per_s);
    std::printf("  %-14s the oscillation %s by %.6f /s (+-%.1g) at %.4f Hz: %s every %.2f s%s\n", verdict, does,
                std::abs(fit.growth_per_s), fit.growth_ci95_per_s, fit.frequency_Hz,
                fit.growth_per_s < 0.0 ? "halves" : "doubles", factor_time_s, beside.c_str());
}

} // namespace berth
