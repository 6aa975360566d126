#include "compensated.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "../firmware/compensation/compensation.h"
#include "../hal/rig/keys.h"
#include "compensation/measured_map.h"
#include "effects/active.h"
#include "hil/manipulator_stand_in.h"
#include "hil/sim_hal.h"
#include "prediction.h"
#include "stability/compensation_states.h"
#include "stability/equivalent_loop.h"
#include "stability/loop_timeline.h"
#include "stability/physical_parameter.h"
#include "stability/spectrum.h"
#include "verdict_words.h"

namespace berth
{

namespace
{

constexpr double furthest = 10.0;
constexpr int steps = 16;
constexpr double near_enough_exact = 1e-4;
constexpr double near_enough_measured = 5e-3; /* the growth of 20 s tells no more */

constexpr const char *dead_time_key = "robot.dead_time_ms";
constexpr const char *by_runs = "by runs of 20 s without noise";
constexpr const char *by_long_runs = "by runs of up to 100 s without noise";

double near_enough_of(const compensated_growth &own)
{
    return own.is_measured ? near_enough_measured : near_enough_exact;
}

/* Another hardware under the same firmware; nothing where no rig may have it. */
std::optional<rig> with_hardware(const rig &original, const rig_key &key, double value)
{
    auto changed = with_value(original, key, value);
    if (changed) {
        changed->firmware = original.firmware;
    }
    return changed;
}

/* The loop by itself: what happens to a run at a time is no part of it. */
rig undisturbed(const rig &original)
{
    rig quiet = original;
    quiet.sensor.noise_N = quiet.robot.feedback_noise_m = 0.0;
    quiet.run.emergency_stop_s = quiet.run.enable_off_s = quiet.run.grip_release_s = quiet.run.dead_time_jump_s =
        never;
    quiet.run.grip_close_s = 0.0;
    return quiet;
}

struct undisturbed_motion {
    motion_evidence evidence;               /* of the first 20 s */
    std::optional<double> lasting_height_m; /* of a swing that does not come to rest, from crest to trough */
};

/* The height of the manipulator's swing in the next seconds. */
double height_within_m(struct hal *hal, struct app &app, manipulator_stand_in &manipulator, std::int64_t ticks)
{
    double lowest_m = app.recorder.tick.manipulator_position_m;
    double highest_m = lowest_m;
    for (std::int64_t i = 0; i < ticks && manipulator.tick(hal, app); i++) {
        lowest_m = std::min(lowest_m, app.recorder.tick.manipulator_position_m);
        highest_m = std::max(highest_m, app.recorder.tick.manipulator_position_m);
    }
    return highest_m - lowest_m;
}

/* A swing that play keeps alive may be a small part of the first one, and is slow to come to its height. */
std::optional<double> lasting_height_m(struct hal *hal, struct app &app, manipulator_stand_in &manipulator,
                                       double start_m, std::int64_t ticks)
{
    constexpr int windows = 4;
    constexpr double at_rest = 1e-3; /* of the start */
    constexpr double falls = 0.9;    /* from window to window: by less it lasts */
    double height_m = height_within_m(hal, app, manipulator, ticks);
    for (int i = 1; i < windows; i++) {
        if (height_m < at_rest * start_m || app.supervisor.state != SUPERVISOR_RUNNING) {
            return {};
        }
        const double before_m = height_m;
        height_m = height_within_m(hal, app, manipulator, ticks);
        if (i == windows - 1 && height_m > falls * before_m) {
            return height_m;
        }
    }
    return {};
}

undisturbed_motion motion_of(const rig &quiet, double start_m)
{
    rig made = quiet;
    const bool is_long = is_judged_by_runs(quiet);
    made.run.duration_s = made.run.release_s + (is_long ? 5.1 : 1.0) * compensated_run_s;
    const std::unique_ptr<struct hal, hal_status (*)(struct hal *)> hal(sim_open(made), hal_close);
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &made.firmware);
    manipulator_stand_in manipulator(made);
    motion_recorder recorder(made);
    const double ends_s = made.run.release_s + compensated_run_s;
    const double period_s = config_period_s(&made.firmware);
    while (app->supervisor.state != SUPERVISOR_STOPPED && manipulator.tick(hal.get(), *app)) {
        recorder.note_tick(app->recorder.tick, false, {});
        if (is_long && period_s * static_cast<double>(app->recorder.tick.index) > ends_s) {
            break;
        }
    }
    undisturbed_motion found{recorder.conclude(), {}};
    if (is_long) {
        found.lasting_height_m = lasting_height_m(hal.get(), *app, manipulator, start_m,
                                                  static_cast<std::int64_t>(compensated_run_s / period_s));
    }
    return found;
}

double deflection_m(const rig &released)
{
    return std::abs(released.firmware.manipulator.initial_position_m - rest_m(released));
}

/* Where the swing is too uneven for a decrement, how much lower it is in the end than before tells. `known`: of
 * small motions, as far as that counts for a larger one. */
stability_verdict judge_run(const rig &quiet, const growth_prediction &known)
{
    const undisturbed_motion seen = motion_of(quiet, deflection_m(quiet));
    const motion_evidence &motion = seen.evidence;
    verdict_case all{known, motion, {}, {}, quiet.firmware.manipulator.mass_kg, {}, ""};
    if (motion.falls == std::optional<bool>(false)) {
        all.cycles = predict_cycles(quiet, motion.height_m);
    }
    stability_verdict found = judge(all);
    if (found.growth) {
        found.growth->origin = growth_origin::trial;
    }
    const bool ended_freely = motion.stop.cause == STOP_NONE && !motion.limits_acted_late;
    if (found.kind == verdict_kind::undetermined && ended_freely) {
        const double growth_per_s = measure(quiet, compensated_run_s).growth_per_s;
        if (std::abs(growth_per_s) > near_enough_measured) {
            found = judge({growth_per_s, {}, 0.0, prediction_source::run}, {});
        }
    } else {
        found.because = "a run without noise: " + found.because;
    }
    if (seen.lasting_height_m && found.is_stable != std::optional<bool>(false)) {
        found = {};
        found.kind = verdict_kind::limit_cycle;
        found.is_stable = false;
        found.because = with_numbers("a run without noise: after %.0f s it still swings at a height of %.3g mm",
                                     5.0 * compensated_run_s, 1e3 * *seen.lasting_height_m);
    }
    found.because +=
        with_numbers("; let go %.3g mm from rest: another start may do otherwise", 1e3 * deflection_m(quiet));
    return found;
}

bool has_no_small_motion(const effect &effect)
{
    return effect.when_small == small_motion::depends_on_size;
}

bool has_limited_drive(const rig &rig)
{
    return rig.robot.velocity_limit_m_per_s != unlimited || rig.robot.acceleration_limit_m_per_s2 != unlimited;
}

/* Where swings of another size than the run's end otherwise; empty: nowhere. */
std::string words_of_cycles(const std::vector<limit_cycle> &cycles, double start_m, bool is_stable)
{
    const auto parts = std::find_if(cycles.begin(), cycles.end(), [&](const limit_cycle &cycle) {
        return !cycle.attracts && (cycle.amplitude_m > start_m) == is_stable;
    });
    if (parts == cycles.end()) {
        return "";
    }
    const auto lasts = std::find_if(parts, cycles.end(), [](const limit_cycle &cycle) { return cycle.attracts; });
    std::string words =
        with_numbers("; harmonic balance: stable for swings below %.3g mm; ", 1e3 * parts->amplitude_m);
    return words + (lasts == cycles.end() ? std::string("larger ones grow")
                                          : with_numbers("beyond that it swings for ever (limit cycle of %.3g mm at "
                                                         "%.4g Hz)",
                                                         1e3 * lasts->amplitude_m, lasts->frequency_Hz));
}

/* Limits of one rig, all seen from the same deflection. */
struct search {
    const rig &original;
    std::optional<double> amplitude_m;

    /* Nothing where no rig may have the value. */
    std::optional<bool> is_stable_with(const rig_key &key, double value) const
    {
        const auto changed = with_hardware(original, key, value);
        return changed ? std::optional<bool>(growth_of_compensated(*changed, amplitude_m).is_stable())
                       : std::nullopt;
    }
};

/* From the rig's own value on by growing factors, up or down. */
std::optional<double> first_change(const search &loop, const rig_key &key, double own, bool is_stable, bool upwards,
                                   double near_enough)
{
    double inside = own;
    for (int i = 1; i <= steps; i++) {
        const double share = std::pow(furthest, static_cast<double>(i) / steps);
        double outside = upwards ? own * share : own / share;
        const auto found = loop.is_stable_with(key, outside);
        if (!found) {
            return {};
        }
        if (*found == is_stable) {
            inside = outside;
            continue;
        }
        while (std::abs(std::log(outside / inside)) > near_enough) {
            const double middle = std::sqrt(inside * outside);
            const bool is_as_own = loop.is_stable_with(key, middle).value_or(!is_stable) == is_stable;
            (is_as_own ? inside : outside) = middle;
        }
        return std::sqrt(inside * outside);
    }
    return {};
}

/* A passivity controller takes out what grows, as far as its settings reach: the loop beneath it tells how near that
 * is. */
std::string words_without_passivity(const rig &rig)
{
    berth::rig without = rig;
    without.firmware.passivity.action = PASSIVITY_OFF;
    if (is_stable(predict_unscheduled(without)) == std::optional<bool>(false)) {
        return "; without its passivity controller the loop is unstable as it is";
    }
    const stability_margin bare = margin_of(without);
    return !bare.dead_time_ms
               ? "; its passivity controller hides what grows beneath it"
               : with_numbers(bare.is_dead_time_open ? "; without its passivity controller by at least %.4g ms"
                                                     : "; without its passivity controller by %.4g ms",
                              *bare.dead_time_ms);
}

std::string note_on_margin(const rig &rig, bool is_measured)
{
    std::string note = is_judged_by_runs(rig) ? by_long_runs : is_measured ? by_runs : "";
    const auto add = [&](const char *words) { note += (note.empty() ? "" : ", ") + std::string(words); };
    if (rig.firmware.arm.kind != ARM_NONE) {
        add("of the arm where it starts");
    }
    if (compensation_is_on(&rig.firmware) || rig.firmware.arm.kind != ARM_NONE) {
        add("with the firmware's settings as they are");
    }
    return note + (rig.firmware.passivity.action != PASSIVITY_OFF ? words_without_passivity(rig) : "");
}

compensated_growth growth_of(const rig &rig, std::optional<double> amplitude_m, const growth_prediction &known)
{
    const berth::rig held = in_contact(rig);
    const bool is_linear = amplitude_m == 0.0 || effects_of_size(held).empty();
    if (compensation_is_linear(held) && is_linear && !is_time_varying(held)) {
        const double growth_per_s = std::log(spectral_radius_of(held)) / config_period_s(&held.firmware);
        const bool touches = rig.object.kind == object_kind::contact;
        growth_prediction found{
            growth_per_s, {}, 0.0, touches ? prediction_source::contact : prediction_source::eigenvalues};
        add_flight(found, rig);
        add_bounces(found, rig);
        return {judge(found, {}), false};
    }
    if (rig.object.kind == object_kind::contact && rig.firmware.manipulator.stiffness_N_per_m > 0.0) {
        stability_verdict in_flight =
            judge_run(undisturbed(released_rig(in_free_flight(rig), amplitude_m.value_or(0.0))), {});
        if (in_flight.is_stable == std::optional<bool>(false)) {
            in_flight.because = "the tool in free flight, where its inertia closes the loop: " + in_flight.because;
            return {in_flight, true};
        }
    }
    const stability_verdict in_run = judge_run(undisturbed(released_rig(held, amplitude_m.value_or(0.0))), known);
    growth_prediction bounces;
    add_bounces(bounces, rig);
    const bool decides =
        in_run.is_stable != std::optional<bool>(false) && (bounces.gains_by_bounces() || bounces.never_touches);
    return {decides ? judge(bounces, {}) : in_run, true};
}

} // namespace

compensated_growth growth_of_compensated(const rig &rig, std::optional<double> amplitude_m)
{
    return growth_of(rig, amplitude_m, {});
}

bool is_judged_by_runs(const rig &rig)
{
    return rig.firmware.arm.kind == ARM_NONE && rig.object.kind != object_kind::none &&
           (has_limited_drive(rig) || !effect_names(rig, has_no_small_motion).empty());
}

stability_verdict verdict_by_runs(const rig &rig, std::optional<double> amplitude_m)
{
    if (!is_judged_by_runs(rig)) {
        return growth_of_compensated(rig, amplitude_m).verdict;
    }
    const growth_prediction small = predict_growth(rig);
    const bool grows_at_first = is_stable(small) == std::optional<bool>(false);
    stability_verdict found = growth_of(rig, amplitude_m, grows_at_first ? small : growth_prediction{}).verdict;
    if (found.is_stable != std::optional<bool>(false) && grows_at_first) {
        return judge(small, {}); /* what grows is too small to be seen in the run, or a limit ended that */
    }
    if (!found.is_stable) {
        return found;
    }
    const bool has_balance = rig.object.kind != object_kind::contact && !compensation_is_on(&rig.firmware);
    if (has_limited_drive(rig) && has_balance) {
        const double start_m = deflection_m(released_rig(rig, amplitude_m.value_or(0.0)));
        found.because += words_of_cycles(limit_cycles(rig, start_m), start_m, *found.is_stable);
    }
    return found;
}

growth_prediction predict_compensated(const rig &rig, std::optional<double> amplitude_m)
{
    const compensated_growth found = growth_of_compensated(rig, amplitude_m);
    const stability_verdict &verdict = found.verdict;
    if (verdict.growth) {
        return {verdict.growth->growth_per_s,
                {},
                verdict.growth->ci95_per_s,
                found.is_measured ? prediction_source::run : prediction_source::eigenvalues};
    }
    if (verdict.is_stable) { /* too short a run for a decrement: how the height of its swing changes */
        const berth::rig quiet = undisturbed(released_rig(in_contact(rig), amplitude_m.value_or(0.0)));
        const double growth_per_s = measure(quiet, compensated_run_s).growth_per_s;
        if ((growth_per_s < 0.0) == *verdict.is_stable) {
            return {growth_per_s, {}, 0.0, prediction_source::run};
        }
    }
    return {{}, verdict.because};
}

std::vector<compensated_limit> limits_of_compensated(const rig &rig, std::optional<double> amplitude_m)
{
    const compensated_growth own = growth_of_compensated(rig, amplitude_m);
    const double near_enough = near_enough_of(own);
    const search loop{rig, amplitude_m};
    std::vector<compensated_limit> found;
    for (const char *const path : {dead_time_key, "object.mass_kg", "object.stiffness_N_per_m"}) {
        const rig_key &key = *find_key(path);
        berth::rig copy = rig;
        const double value = *static_cast<double *>(key.member(copy));
        if (value > 0.0) {
            const bool is_stable = own.is_stable();
            found.push_back({key.path, value, first_change(loop, key, value, is_stable, false, near_enough),
                             first_change(loop, key, value, is_stable, true, near_enough)});
        }
    }
    return found;
}

stability_margin margin_of_compensated(const rig &rig, const compensated_growth &own,
                                       const std::vector<compensated_limit> &limits)
{
    if (!own.is_stable()) {
        return {{}, false, {}, false, own.verdict.is_stable ? "" : own.verdict.because};
    }
    for (const compensated_limit &limit : limits) {
        if (limit.key == dead_time_key) {
            const double longest_ms = limit.above.value_or(furthest * limit.value);
            return {longest_ms - limit.value, !limit.above, {}, false, note_on_margin(rig, own.is_measured)};
        }
    }
    return {{}, false, {}, false, "robot.dead_time_ms is 0, and multiples of it are searched"};
}

stability_margin margin_of_compensated(const rig &rig, std::optional<double> amplitude_m)
{
    const compensated_growth own = growth_of_compensated(rig, amplitude_m);
    const double value_ms = rig.robot.dead_time_ms;
    if (!own.is_stable() || !(value_ms > 0.0)) {
        return margin_of_compensated(rig, own, {});
    }
    const auto above =
        first_change({rig, amplitude_m}, *find_key(dead_time_key), value_ms, true, true, near_enough_of(own));
    return margin_of_compensated(rig, own, {{dead_time_key, value_ms, {}, above}});
}

} // namespace berth
