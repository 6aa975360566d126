#include "margin.h"

#include "../firmware/compensation/compensation.h"
#include "../hal/rig/rig_file.h"
#include "bounce_limits.h"
#include "compensated.h"
#include "effects/active.h"
#include "flight_limits.h"
#include "prediction.h"
#include "stability/compensation_states.h"
#include "stability/equivalent_loop.h"
#include "stability/gains.h"
#include "stability/limits.h"
#include "stability/loop_equation.h"
#include "stability/loop_timeline.h"
#include "stability/stable_intervals.h"

namespace berth
{

namespace
{

/* A margin takes some thirty times as long as a prediction. */
constexpr int searched_degree_max = 200;

stability_margin none_because(const std::string &why)
{
    stability_margin none;
    none.note = why;
    return none;
}

/* Of a robot without an object: the force that it feels has nothing to do with its motion. */
stability_margin unlimited_margin()
{
    stability_margin any;
    any.is_unlimited = true;
    any.note = "no limit: nothing feeds back, so any dead time will do";
    return any;
}

/* Of a loop that has a loop equation. */
stability_margin margin_of_plain(const rig &rig)
{
    const berth::rig linear = in_contact(rig);
    if (const int degree = make_loop_equation(linear).degree(); degree > searched_degree_max) {
        return none_because("the loop has " + std::to_string(degree) + " eigenvalues: `berth limits` takes longer");
    }
    stability_margin margin;
    if (const auto quality = quality_of(linear)) {
        margin.modulus = quality->margin;
    }
    if (margin.modulus) {
        parameter_limits dead_time = find_limits(linear, "robot.dead_time_ms");
        cut_by_flight(dead_time, rig);
        cut_by_bounces(dead_time, rig);
        margin.dead_time_ms = dead_time_margin_ms(linear, dead_time);
        margin.is_dead_time_open = !margin.dead_time_ms;
        margin.stable_again_ms = stable_beyond(dead_time);
        margin.is_again_open = is_open_beyond(dead_time);
        margin.dead_time_ms = margin.dead_time_ms.value_or(dead_time.to - dead_time.value);
    }
    return margin;
}

/* By runs, and by eigenvalues where small motions have them: what grows may be too small to be seen in a run. */
stability_margin margin_of_size(const rig &rig, std::optional<double> amplitude_m)
{
    stability_margin by_runs = margin_of_compensated(rig, amplitude_m);
    if (!by_runs.dead_time_ms || compensation_is_on(&rig.firmware) || drifts_freely(in_contact(rig)) ||
        !left_out_when_small(in_contact(rig)).empty()) {
        return by_runs;
    }
    const stability_margin small = margin_of_plain(rig);
    const bool is_small_nearer = small.dead_time_ms && *small.dead_time_ms < *by_runs.dead_time_ms;
    return is_small_nearer ? small : by_runs;
}

/* Of one that is the same in each tick. */
stability_margin margin_of_steady(const rig &rig, std::optional<double> amplitude_m)
{
    const berth::rig linear = in_contact(rig);
    if (touches_nothing(rig)) {
        return unlimited_margin();
    }
    const bool has_arm = linear.firmware.arm.kind != ARM_NONE;
    if (has_arm && !compensation_is_linear(linear)) {
        return none_because("an arm with a compensation that has no eigenvalues");
    }
    if (is_judged_by_runs(rig) && amplitude_m != 0.0) {
        return margin_of_size(rig, amplitude_m);
    }
    if (compensation_is_on(&linear.firmware) || has_arm) {
        return margin_of_compensated(rig, amplitude_m);
    }
    if (const std::vector<std::string> left_out = left_out_when_small(linear); !left_out.empty()) {
        return none_because(left_out.front());
    }
    if (drifts_freely(linear)) {
        return none_because("no spring holds manipulator or object");
    }
    return margin_of_plain(rig);
}

} // namespace

stability_margin margin_of(const rig &rig, std::optional<double> amplitude_m)
try {
    if (is_time_varying(rig) && compensation_is_on(&rig.firmware) && rig.firmware.arm.kind == ARM_NONE) {
        return margin_of_compensated(rig); /* by runs, in which it varies */
    }
    const bool varies = is_time_varying(rig);
    stability_margin margin = margin_of_steady(varies ? without_variation(rig) : rig, amplitude_m);
    if (varies && (margin.dead_time_ms || margin.modulus)) {
        margin.note += std::string(margin.note.empty() ? "" : ", ") + "without what changes from tick to tick";
    }
    return margin;
} catch (const input_error &error) {
    return none_because(error.what());
}

} // namespace berth
