#include "chooser.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../../firmware/compensation/compensation.h"
#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "measured_map.h"

namespace berth
{

namespace
{

/* Below this nothing moves. */
constexpr double least_swing_m = 1e-9;

/* Of the trial with noise, for a rig that tells of none. */
constexpr double least_noise_N = 2.0;

std::string setting(std::string_view key, double value)
{
    char text[120];
    std::snprintf(text, sizeof text, "%.*s=%.9g", static_cast<int>(key.size()), key.data(), value);
    return text;
}

double number_of(const rig &of, std::string_view key)
{
    rig copy = of;
    return *static_cast<double *>(find_key(key)->member(copy));
}

/* Nothing: the rig would be refused. */
std::optional<rig> with_settings(const rig &of, const std::vector<std::string> &settings)
{
    rig changed = of;
    for (const std::string &one : settings) {
        const std::size_t equals = one.find('=');
        if (set_value(changed, one.substr(0, equals), one.substr(equals + 1))) {
            return {};
        }
    }
    return complete_and_check(changed) ? std::optional<rig>() : changed;
}

/* What a swing of the loop stores, roughly: a passivity controller's credit is counted in it. */
double usual_energy_J(const rig &rig)
{
    const manipulator_config &arm = rig.firmware.manipulator;
    const double way_m =
        std::max({std::abs(arm.initial_position_m - rest_m(rig)), std::abs(rig.profile.amplitude_m), 1e-3});
    const double stiffness = arm.stiffness_N_per_m + rig.object.stiffness_N_per_m;
    return 0.5 * stiffness * way_m * way_m +
           0.5 * arm.mass_kg * arm.initial_velocity_m_per_s * arm.initial_velocity_m_per_s;
}

std::string number(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, value < 100.0 ? "%.3g" : "%.0f", value);
    return text;
}

/* The one that the eigenvalues ask for, and larger ones; a tool in contact has no eigenvalues. */
void add_dissipators(std::vector<method> &methods, const choice_request &request)
{
    const rig &rig = request.rig;
    const manipulator_config &arm = rig.firmware.manipulator;
    double least = 0.2 * std::sqrt(arm.mass_kg * (arm.stiffness_N_per_m + rig.object.stiffness_N_per_m));
    if (rig.object.kind == object_kind::gripped) {
        least = least_damping(rig, request.margin).value_or(least);
    }
    for (const double factor : {1.0, 2.0, 4.0}) {
        if (least > 0.0) {
            methods.push_back({"dissipation of " + number(factor * least) + " N s/m",
                               {setting("dissipation.damping_N_s_per_m", factor * least)}});
        }
    }
}

std::vector<method> methods_for(const choice_request &request)
{
    const rig &rig = request.rig;
    std::vector<method> methods{{"none", {}}};
    for (int order = 1; order <= EXTRAPOLATION_ORDER_MAX; order++) {
        methods.push_back({"extrapolation-" + std::to_string(order), {setting("extrapolation.order", order)}});
    }
    const std::vector<std::string> inverse{"adaptive_inverse.enabled=true"};
    methods.push_back({"adaptive inverse", inverse});
    methods.push_back({"force lead", {"force_lead.enabled=true"}});
    methods.push_back({"adaptive inverse, force lead", {inverse.front(), "force_lead.enabled=true"}});
    for (const double bandwidth_Hz : {1.0, 5.0, 20.0}) {
        const std::vector<std::string> predicting{"prediction.enabled=true",
                                                  setting("prediction.error_bandwidth_Hz", bandwidth_Hz)};
        const std::string at = " at " + std::to_string(static_cast<int>(bandwidth_Hz)) + " Hz";
        methods.push_back({"prediction" + at, predicting});
        methods.push_back({"identification" + at, predicting});
        methods.back().settings.emplace_back("identification.enabled=true");
    }
    const double credit_J = 0.1 * usual_energy_J(rig);
    const std::vector<std::string> damping{"passivity.action=damping", setting("passivity.credit_J", credit_J)};
    for (const double horizon_ms : {10.0, 20.0, 50.0}) {
        methods.push_back({"passivity over " + number(horizon_ms) + " ms", damping});
        methods.back().settings.push_back(setting("passivity.horizon_ms", horizon_ms));
    }
    methods.push_back({"tank", {"passivity.action=tank", setting("passivity.credit_J", credit_J)}});
    add_dissipators(methods, request);
    methods.push_back(
        {"identification at 5 Hz, passivity",
         {"prediction.enabled=true", "prediction.error_bandwidth_Hz=5", "identification.enabled=true"}});
    methods.back().settings.insert(methods.back().settings.end(), damping.begin(), damping.end());
    return methods;
}

std::vector<difference> differences_for(const choice_request &request)
{
    const rig &rig = request.rig;
    std::vector<difference> all{{"as given", {}}};
    const auto scale = [&](std::string_view key, double share) {
        const double value = number_of(rig, key);
        if (value == 0.0) {
            return;
        }
        for (const double factor : {1.0 - share, 1.0 + share}) {
            char name[80];
            std::snprintf(name, sizeof name, "%.*s %+.0f %%", static_cast<int>(key.size()), key.data(),
                          100.0 * (factor - 1.0));
            all.push_back({name, {setting(key, factor * value)}});
        }
    };
    scale("robot.dead_time_ms", request.dead_time_share);
    scale("object.stiffness_N_per_m", request.stiffness_share);
    scale("object.mass_kg", request.mass_share);
    const double noise_N = request.noise_N.value_or(std::max(least_noise_N, 10.0 * rig.sensor.noise_N));
    all.push_back({"force noise of " + number(noise_N) + " N", {setting("sensor.noise_N", noise_N)}});
    all.push_back({"one frame in 100 lost", {"bus.loss_probability=0.01"}});
    const double event_s = rig.run.release_s + 0.25 * request.duration_s;
    char jump[80];
    std::snprintf(jump, sizeof jump, "robot.dead_time_ms %+.0f %% on the way", 100.0 * request.dead_time_share);
    all.push_back({jump,
                   {setting("run.dead_time_jump_s", event_s),
                    setting("run.dead_time_jump_ms", request.dead_time_share * rig.robot.dead_time_ms)}});
    if (rig.object.kind == object_kind::gripped) {
        all.push_back({"object let go on the way", {setting("run.grip_release_s", event_s)}});
    }
    return all;
}

/* The rig is different, and the loop does not know. */
trial_result try_on(const rig &different, const rig &told, double duration_s)
{
    rig running = different;
    running.firmware = told.firmware;
    return run_trial(running, duration_s);
}

method_verdict judge(const method &method, const std::vector<rig> &rigs, double duration_s)
{
    method_verdict verdict{method, {}, true, 0.0, 0.0, 0};
    const auto told = with_settings(rigs.front(), method.settings);
    if (!told) {
        verdict.is_robust = false;
        return verdict;
    }
    for (std::size_t i = 0; i < rigs.size(); i++) {
        const trial_result trial = try_on(rigs[i], *told, duration_s);
        const bool holds = trial.ran && trial.is_bounded;
        if (verdict.is_robust && (!holds || trial.error > verdict.worst_error)) {
            verdict.worst_error = trial.error;
            verdict.worst = i;
        }
        verdict.is_robust = verdict.is_robust && holds;
        verdict.trials.push_back(trial);
    }
    verdict.error = verdict.trials.front().error;
    return verdict;
}

/* On the rig as told, if it could be and ran. */
bool moves(const method_verdict &verdict)
{
    return verdict.trials.empty() || !verdict.trials.front().ran || verdict.trials.front().swing_m > least_swing_m;
}

} // namespace

choice choose_compensation(const choice_request &request, const std::function<void(double)> &tried)
{
    if (compensation_is_on(&request.rig.firmware)) {
        throw input_error("the rig has compensation already (extrapolation, adaptive inverse, force lead, "
                          "prediction, dissipation or passivity); "
                          "leave it out, to see which suits it");
    }
    choice made;
    std::vector<rig> rigs;
    for (const difference &each : differences_for(request)) {
        if (const auto different = with_settings(request.rig, each.settings)) {
            made.differences.push_back(each);
            rigs.push_back(*different);
        } else {
            made.impossible.push_back(each.name);
        }
    }
    const std::vector<method> methods = methods_for(request);
    for (const method &one : methods) {
        made.methods.push_back(judge(one, rigs, request.duration_s));
        if (!moves(made.methods.back())) {
            throw input_error("nothing moves on this rig, so there is nothing to compare: give it a profile, "
                              "manipulator.initial_position_m or manipulator.initial_velocity_m_per_s");
        }
        if (tried) {
            tried(static_cast<double>(made.methods.size()) / static_cast<double>(methods.size()));
        }
    }
    std::stable_sort(made.methods.begin(), made.methods.end(), [](const auto &a, const auto &b) {
        return a.is_robust != b.is_robust ? a.is_robust : a.is_robust && a.worst_error < b.worst_error;
    });
    return made;
}

std::vector<helpful_change> what_would_help(const choice_request &request)
{
    std::vector<helpful_change> found;
    const struct {
        std::string_view key;
        double factor;
    } changes[] = {{"robot.dead_time_ms", 0.5},       {"robot.dead_time_ms", 0.25},
                   {"object.stiffness_N_per_m", 0.5}, {"object.damping_N_s_per_m", 4.0},
                   {"object.mass_kg", 0.5},           {"manipulator.mass_kg", 2.0}};
    for (const auto &change : changes) {
        const double from = number_of(request.rig, change.key);
        const auto changed = with_settings(request.rig, {setting(change.key, change.factor * from)});
        if (from == 0.0 || !changed) {
            continue;
        }
        choice_request other = request;
        other.rig = *changed;
        if (const choice made = choose_compensation(other); made.recommended() != nullptr) {
            found.push_back({std::string(change.key), from, change.factor * from, made.recommended()->method});
        }
    }
    return found;
}

} // namespace berth
