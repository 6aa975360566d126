#include "map_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../answer.h"
#include "../schedule.h"
#include "../stability/lyapunov.h"
#include "amplitude.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

/* Negative: gained. */
double lost_share(const map_summary &sums)
{
    return sums.stable_intervals > 0.0 ? 1.0 - sums.stable_intervals_varying / sums.stable_intervals : 0.0;
}

nlohmann::json axis_json(const map_axis &axis)
{
    return {{"name", axis.name}, {"from", axis.from}, {"to", axis.to}, {"count", axis.count}};
}

/* Where the robot has further axes: which of them an axis of the map is about. */
std::vector<std::string> what_moves(const map_request &request)
{
    std::vector<std::string> lines;
    if (!request.rig.has_side_axes()) {
        return lines;
    }
    if (request.kind != map_kind::keys) {
        return {"the object along x alone is varied; [axis.*] has its own along the others"};
    }
    for (const std::string &name : {request.x.name, request.y.name}) {
        const bool is_of_x =
            name.rfind("object.", 0) == 0 || name == "sensor.stiffness_N_per_m" || name == "sensor.damping_ratio";
        if (name == "robot.dead_time_ms") {
            lines.push_back(name + " moves the dead times of all axes by the same amount; it is that along x");
        } else if (is_of_x) {
            lines.push_back(name + " is that along x alone; [axis.*] has its own along the others");
        }
    }
    return lines;
}

double own_value(const rig &rig, const std::string &name)
{
    if (const rig_key *const key = find_key(name)) {
        void *const member = key->member(const_cast<berth::rig &>(rig));
        return key->type == key_type::integer ? static_cast<double>(*static_cast<std::int64_t *>(member))
                                              : *static_cast<double *>(member);
    }
    const map_point point = map_point_of(rig);
    return name == frequency_ratio_axis ? point.frequency_ratio : point.damping_ratio;
}

nlohmann::json share(std::size_t part, std::size_t of)
{
    return of > 0 ? nlohmann::json(static_cast<double>(part) / static_cast<double>(of)) : nlohmann::json();
}

/* The rig itself, as it is when its schedule is at its worst. */
rig worst_rig(const map_request &request)
{
    return worst_of_schedule(request.rig, predictor_at(request.amplitude_m)).rig;
}

nlohmann::json own_as_json(const map_request &request, double run_s)
{
    const double period_s = config_period_s(&request.rig.firmware);
    nlohmann::json own{{"x", own_value(request.rig, request.x.name)}, {"y", own_value(request.rig, request.y.name)}};
    if (run_s > 0.0) {
        const measured_point found = measure(request.rig, run_s);
        own.update({{"spectral_radius", std::exp(found.growth_per_s * period_s)},
                    {"growth_per_s", found.growth_per_s},
                    {"fidelity_error", found.error},
                    {"stable", found.fate == fate::decays}});
        return own;
    }
    const settled_rig at = settle_at(worst_rig(request), request.amplitude_m);
    const double radius = spectral_radius_of(at.linear);
    const double growth_per_s = std::log(radius) / period_s;
    own.update(
        {{"spectral_radius", radius},
         {"growth_per_s", growth_per_s},
         {"stable", unless_guess(at.has_settled, stable_json(growth_per_s, radius, drifts_freely(at.linear)))}});
    return own;
}

/* Shares and extremes, and the rig itself. */
nlohmann::json sums_as_json(const map_request &request, const map_sums &sums, double run_s = 0.0)
{
    const bool has_points = sums.possible > 0;
    return {{"stable_share", share(sums.stable, sums.possible)},
            {"stable_share_below_wall", share(sums.stable_below_wall, sums.below_wall)},
            {"spectral_radius_min", has_points ? nlohmann::json(sums.least) : nlohmann::json()},
            {"spectral_radius_max", has_points ? nlohmann::json(sums.largest) : nlohmann::json()},
            {"own", own_as_json(request, run_s)}};
}

nlohmann::json varying_as_json(const map_job &job, const map_summary &sums)
{
    const rig &rig = job.varying->rig;
    const lyapunov_exponent own =
        exponent_of(linear_at(worst_rig(*job.varying), job.varying->amplitude_m), job.histogram);
    return {{"varies", what_varies(rig, job.histogram)},
            {"ticks", job.ticks},
            {"seed", rig.run.seed},
            {"stable_share", share(sums.varying.stable, sums.varying.possible)},
            {"stable_share_below_wall", share(sums.varying.stable_below_wall, sums.varying.below_wall)},
            {"lost_share_of_stable_area", lost_share(sums)},
            {"own_growth_per_s", own.growth_per_s},
            {"own_growth_ci95_per_s", own.ci95_per_s}};
}

double percent(std::size_t part, std::size_t of)
{
    return of > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(of) : 0.0;
}

const char *name_of(told_model told)
{
    return told == told_model::of_the_rig ? "rig" : told == told_model::with_tolerances ? "tolerances" : "point";
}

nlohmann::json measured_as_json(const map_summary &sums, double run_s)
{
    const measured_sums &found = sums.measured;
    return {{"run_s", run_s},
            {"lasting_share", share(found.lasting, sums.steady.possible)},
            {"lasting_share_below_wall", share(found.lasting_below_wall, sums.steady.below_wall)},
            {"faulted_share", share(found.faulted, sums.steady.possible)},
            {"faulted_share_below_wall", share(found.faulted_below_wall, sums.steady.below_wall)},
            {"faithful_error", true_error},
            {"faithful_share", share(found.faithful, sums.steady.possible)},
            {"faithful_share_below_wall", share(found.faithful_below_wall, sums.steady.below_wall)}};
}

void print_measured(const map_summary &sums, double run_s)
{
    const measured_sums &found = sums.measured;
    std::printf("  TIME DOMAIN, no eigenvalues: each point let go and run for %g s; stable is a swing that decays\n",
                run_s);
    std::printf("  swings on without growing: %.1f %%, %.1f %% of those below the wall\n",
                percent(found.lasting, sums.steady.possible),
                percent(found.lasting_below_wall, sums.steady.below_wall));
    std::printf("  ended by a fault before they grew: %.1f %%, %.1f %% of those below the wall\n",
                percent(found.faulted, sums.steady.possible),
                percent(found.faulted_below_wall, sums.steady.below_wall));
    std::printf("  stable, and within %g %% of the motion without dead time: %.1f %%, %.1f %% of those below the "
                "wall\n",
                100.0 * true_error, percent(found.faithful, sums.steady.possible),
                percent(found.faithful_below_wall, sums.steady.below_wall));
}

/* With what makes the loop change from tick to tick. */
void print_varying(const map_summary &sums, const nlohmann::json &varying)
{
    for (const nlohmann::json &effect : varying["varies"]) {
        std::printf("  %s:\n", effect.get<std::string>().c_str());
    }
    const double lost = 100.0 * lost_share(sums);
    std::printf("    %.1f %% stable, %.1f %% of those below the wall; %.2f %% of the stable area %s\n",
                percent(sums.varying.stable, sums.varying.possible),
                percent(sums.varying.stable_below_wall, sums.varying.below_wall), std::abs(lost),
                lost >= 0.0 ? "lost" : "gained");
}

/* Where the rig lies on the map, and what it is there. */
void print_own(const map_request &request, const nlohmann::json &own)
{
    const nlohmann::json &stable = own["stable"];
    std::printf("  the rig itself: %s = %g, %s = %g: %s, growth %+.6f /s, largest |z| %.9f\n",
                axis_title(request.x).c_str(), own["x"].get<double>(), axis_title(request.y).c_str(),
                own["y"].get<double>(), stable.is_null() ? "undetermined" : stability_word(stable == true).c_str(),
                own["growth_per_s"].get<double>(), own["spectral_radius"].get<double>());
}

/* With a range of dead times: from its upper to its lower end. */
void print_robot(const map_sums &lower_end, const nlohmann::json &json)
{
    if (!json["robot"].is_null()) {
        std::printf("  robot %s\n", robot_sentence(json["robot"]).c_str());
    }
    const nlohmann::json &lower = json["lower_end"];
    if (lower_end.possible > 0) {
        std::printf("  at the lower end, %g ms, stable at %.1f %% of the points",
                    lower["dead_time_ms"].get<double>(), percent(lower_end.stable, lower_end.possible));
        if (lower_end.below_wall > 0) {
            std::printf(", of those below the wall at %.1f %%",
                        percent(lower_end.stable_below_wall, lower_end.below_wall));
        }
        std::printf("; the rig itself: |z| %.9f\n", lower["own"]["spectral_radius"].get<double>());
    }
}

/* Of the rig itself, where it is stable by its eigenvalues. */
stability_margin own_margin(const map_job &job, const nlohmann::json &stable)
{
    if (job.run_s > 0.0 || stable != true) {
        return {};
    }
    const double amplitude_m = job.request.amplitude_m;
    return amplitude_m > 0.0 ? margin_of(linear_at(job.chosen.rig, amplitude_m))
                             : answer_of(job.chosen.rig, predict_unscheduled, 0.0).margin;
}

} // namespace

std::vector<std::string> left_out_of_map(const map_job &job)
{
    const rig &rig = job.request.rig;
    if (job.run_s > 0.0) {
        return {};
    }
    return left_out(has_schedule(rig) ? rig_at(rig, instants_of_schedule(rig).front()) : rig,
                    job.request.amplitude_m);
}

nlohmann::json as_json(const map_job &job, const map_summary &sums)
{
    const map_request &request = job.request;
    const manipulator_config &arm = request.rig.firmware.manipulator;
    const double arm_Hz = std::sqrt(arm.stiffness_N_per_m / arm.mass_kg) / 6.28318530717958647692;
    nlohmann::json json = sums_as_json(request, sums.steady, job.run_s);
    json.update({{"rig", request.rig.name},
                 {"robot", robot_as_json(job.chosen)},
                 {"lower_end", nullptr},
                 {"method", job.run_s > 0.0 ? "time domain" : "eigenvalues"},
                 {"model", name_of(request.told)},
                 {"time_domain", job.run_s > 0.0 ? measured_as_json(sums, job.run_s) : nlohmann::json()},
                 {"amplitude_m", request.amplitude_m > 0.0 ? nlohmann::json(request.amplitude_m) : nlohmann::json()},
                 {"varying", job.varying ? varying_as_json(job, sums) : nlohmann::json()},
                 {"vary", request.kind == map_kind::mass         ? nlohmann::json("mass")
                          : request.kind == map_kind::elasticity ? nlohmann::json("elasticity")
                                                                 : nlohmann::json()},
                 {"axes", {{"x", axis_json(request.x)}, {"y", axis_json(request.y)}}},
                 {"points", request.points()},
                 {"points_possible", sums.steady.possible},
                 {"points_not_passive", sums.not_passive},
                 {"points_invalid", sums.invalid},
                 {"wall_Hz", wall_Hz},
                 {"manipulator_Hz", arm_Hz}});
    json["bounces"] = nullptr;
    if (sums.bounces.played > 0) {
        json["bounces"] = {{"gaining_share", share(sums.bounces.gaining, sums.bounces.played)},
                           {"restitution_min", sums.bounces.least},
                           {"restitution_max", sums.bounces.largest}};
    }
    json["reduced"] = nullptr;
    json["margin"] = margin_json(own_margin(job, json["own"]["stable"]));
    json["moves"] = what_moves(request);
    json["scheduled_at_s"] =
        has_schedule(request.rig) && job.run_s == 0.0 ? instants_of_schedule(request.rig) : std::vector<double>();
    json["left_out"] = left_out_of_map(job);
    if (sums.misled.compared > 0) {
        json["reduced"] = {{"falsely_stable_share", share(sums.misled.falsely_stable, sums.misled.compared)},
                           {"falsely_unstable_share", share(sums.misled.falsely_unstable, sums.misled.compared)}};
    }
    if (job.lower_end) {
        json["lower_end"] = sums_as_json(*job.lower_end, sums.lower_end);
        json["lower_end"]["dead_time_ms"] = job.lower_end->rig.robot.dead_time_ms;
    }
    return json;
}

void print_map_summary(const map_request &request, const map_summary &sums, const nlohmann::json &json)
{
    std::printf("%s: %s from %g to %g, %s from %g to %g\n", request.rig.name.c_str(), axis_title(request.x).c_str(),
                request.x.from, request.x.to, axis_title(request.y).c_str(), request.y.from, request.y.to);
    std::printf("  stable at %.1f %% of %zu points; of those below %g Hz, which the robot can follow, at %.1f %%\n",
                percent(sums.steady.stable, sums.steady.possible), sums.steady.possible, wall_Hz,
                percent(sums.steady.stable_below_wall, sums.steady.below_wall));
    if (sums.bounces.played > 0) {
        std::printf("  eigenvalues are those in contact, or in free flight where only that grows; a bounce gains "
                    "energy at %.1f "
                    "%%, restitution from %.4f to %.4f\n",
                    percent(sums.bounces.gaining, sums.bounces.played), sums.bounces.least, sums.bounces.largest);
    }
    if (!json["time_domain"].is_null()) {
        print_measured(sums, json["time_domain"]["run_s"].get<double>());
    }
    if (request.told != told_model::of_the_point) {
        std::printf("  in the loop's model: %s\n", request.told == told_model::of_the_rig
                                                       ? "the rig as it is, wherever the point is"
                                                       : "each point wrong by a tolerance; the worst of all");
    }
    if (request.amplitude_m > 0.0) {
        std::printf("  describing function at %g m, at each point with its own frequency\n", request.amplitude_m);
    }
    if (sums.misled.compared > 0) {
        std::printf(
            "  of the whole arm; its reduction to one degree of freedom is wrongly stable at %.1f %%, wrongly "
            "unstable at %.1f %%\n",
            percent(sums.misled.falsely_stable, sums.misled.compared),
            percent(sums.misled.falsely_unstable, sums.misled.compared));
    }
    if (!json["scheduled_at_s"].empty()) {
        std::printf("  the rig file schedules a change of the loop: each point is as bad as the worst of its %zu "
                    "instants\n",
                    json["scheduled_at_s"].size());
    }
    for (const nlohmann::json &line : json["moves"]) {
        std::printf("  %s\n", line.get<std::string>().c_str());
    }
    if (!json["varying"].is_null()) {
        print_varying(sums, json["varying"]);
    }
    if (sums.not_passive > 0) {
        std::printf("  %zu points left out (nan): they need a negative stiffness, damping or mass of the object\n",
                    sums.not_passive);
    }
    if (sums.invalid > 0) {
        std::printf("  %zu points left out (nan): there the rig is not valid, or like no linear loop\n",
                    sums.invalid);
    }
    if (sums.steady.possible > 0) {
        std::printf("  largest |z| from %.9f to %.9f; stable is below 1\n", sums.steady.least, sums.steady.largest);
    }
    print_own(request, json["own"]);
    if (const nlohmann::json &margin = json["margin"]["sentence"]; !margin.is_null()) {
        std::printf("  %-14s %s\n", "margin", margin.get<std::string>().c_str());
    }
    print_robot(sums.lower_end, json);
    std::printf("  %.3f s for the map\n", json["compute_s"].get<double>());
}

} // namespace berth
