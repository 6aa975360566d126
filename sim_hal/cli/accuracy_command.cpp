#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../../hal/rig/arm_file.h"
#include "../../hal/rig/beam.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/toml_file.h"
#include "../arm/accuracy.h"
#include "commands.h"
#include "progress_line.h"

namespace berth
{

namespace
{

constexpr std::array integrator_names = {"semi_implicit_euler", "rk4", "implicit_midpoint"};
constexpr std::array force_names = {"mean", "held", "led"};
constexpr std::array force_meanings = {"the integrator alone: it is given the true force's mean over each step",
                                       "the force at a step's begin held over it", "that force led by half a step"};

constexpr double reference_step_ms = 2.5;

/* Beyond this the steps have blown up; a tool is nowhere near it. */
constexpr double lost_m = 1.0;

const char *name_of(arm_integrator integrator)
{
    return integrator_names[static_cast<std::size_t>(integrator)];
}

/* The manoeuvre is one of steps, not of guidance: which joints it leads past their limits, so that a run would not.
 */
std::vector<std::string> beyond_limits(const arm_config &arm, const berthing_plan &plan)
{
    std::vector<std::string> beyond;
    const std::vector<joint_demand> demands = berthing_demands(arm, plan);
    for (std::size_t i = 0; i < demands.size(); i++) {
        const arm_joint &joint = arm.joints[i];
        char text[160];
        if (demands[i].rate_rad_per_s > joint.rate_limit_rad_per_s) {
            std::snprintf(text, sizeof text, "joint %zu turns at %.3g rad/s, its rate_limit_rad_per_s is %g", i + 1,
                          demands[i].rate_rad_per_s, joint.rate_limit_rad_per_s);
            beyond.emplace_back(text);
        }
        if (demands[i].least_rad < joint.angle_min_rad || demands[i].most_rad > joint.angle_max_rad) {
            std::snprintf(text, sizeof text, "joint %zu goes from %.4g to %.4g rad, its range is %g to %g", i + 1,
                          demands[i].least_rad, demands[i].most_rad, joint.angle_min_rad, joint.angle_max_rad);
            beyond.emplace_back(text);
        }
    }
    return beyond;
}

/* JSON has no infinity. */
nlohmann::json finite(double value)
{
    return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

/* What is measured: an arm with a usual object, or a rig's own. */
struct measured_arm {
    arm_description arm;
    std::string text; /* as a run with this arm has it in its log: tells a report whether it is about the same one */
    berthing_plan plan;
    double step_ms = reference_step_ms; /* that the verdict is about: a rig's period, unless another is wanted */
};

/* What the loop does with this arm. */
berthing_force own_force(const measured_arm &measured)
{
    return measured.arm.config.force == ARM_FORCE_LED ? berthing_force::led : berthing_force::held;
}

/* Of the arm's own integrator, in the steps that the firmware makes. */
const accuracy_row &own_row(const measured_arm &measured, const accuracy &found, berthing_force force)
{
    const arm_config &arm = measured.arm.config;
    return row_at(found, static_cast<arm_integrator>(arm.integrator), force, measured.step_ms, arm.substeps);
}

nlohmann::json as_json(const measured_arm &measured, const accuracy &found, const accuracy_arguments &arguments)
{
    const arm_description &arm = measured.arm;
    nlohmann::json rows = nlohmann::json::array();
    for (const accuracy_row &row : found.rows) {
        nlohmann::json entry = {{"integrator", name_of(row.integrator)},
                                {"force", force_names[static_cast<std::size_t>(row.force)]},
                                {"step_ms", row.step_ms},
                                {"substeps", row.substeps},
                                {"tool_m", finite(row.tool_m)},
                                {"energy_J", finite(row.energy_J)}};
        if (row.force != berthing_force::mean) {
            entry["force_N"] = finite(row.force_N);
        }
        rows.push_back(entry);
    }
    nlohmann::json drifts; /* null: the base is held */
    for (std::size_t i = 0; i < found.drifts.size(); i++) {
        const momentum_drift &drift = found.drifts[i];
        drifts[name_of(static_cast<arm_integrator>(i))] = {{"angular_N_m_s", finite(drift.angular_N_m_s)},
                                                           {"linear_N_s", finite(drift.linear_N_s)},
                                                           {"moved_N_s", finite(drift.moved_N_s)}};
    }
    const auto integrator = static_cast<arm_integrator>(arm.config.integrator);
    return {{"arm", arm.name},
            {"arm_hash", text_hash(measured.text)},
            {"integrator", name_of(integrator)},
            {"step_ms", measured.step_ms},
            {"substeps", arm.config.substeps},
            {"force", force_names[static_cast<std::size_t>(own_force(measured))]},
            {"loop_tool_m", finite(own_row(measured, found, own_force(measured)).tool_m)},
            {"repeatability_m", 1e-6 * arguments.repeatability_um},
            {"tool_m", finite(own_row(measured, found, berthing_force::mean).tool_m)},
            {"held_tool_m", finite(own_row(measured, found, berthing_force::held).tool_m)},
            {"led_tool_m", finite(own_row(measured, found, berthing_force::led).tool_m)},
            {"truth_m", found.truth_m},
            {"events", found.events},
            {"largest_force_N", found.force_N},
            {"largest_energy_J", found.energy_J},
            {"rows", rows},
            {"momentum_drift", drifts},
            {"beyond_limits", beyond_limits(arm.config, measured.plan)}};
}

void print_error(double tool_m)
{
    if (tool_m < lost_m) {
        std::printf(" %20.4g", 1e6 * tool_m);
    } else {
        std::printf(" %20s", "unstable");
    }
}

/* Two digits, and no more of them than that behind a point. */
std::string percent_text(double percent)
{
    char text[32];
    std::snprintf(text, sizeof text, percent < 100.0 ? "%.2g" : "%.0f", percent);
    return text;
}

/* "2.5", or "2.5 / 4" in substeps. */
std::string step_text(double step_ms, std::int64_t substeps)
{
    char text[48];
    if (substeps > 1) {
        std::snprintf(text, sizeof text, "%g / %d", step_ms, static_cast<int>(substeps));
    } else {
        std::snprintf(text, sizeof text, "%g", step_ms);
    }
    return text;
}

void print_table(const measured_arm &measured, const accuracy &found, berthing_force force)
{
    std::printf("\nlargest error of the tool in um; %s%s\n  %8s", force_meanings[static_cast<std::size_t>(force)],
                force == own_force(measured) ? ", as the loop does" : "", "step ms");
    for (const char *const name : integrator_names) {
        std::printf(" %20s", name);
    }
    std::printf("\n");
    const auto print_row = [&](double step_ms, std::int64_t substeps) {
        std::printf("  %8s", step_text(step_ms, substeps).c_str());
        for (int i = 0; i < ARM_INTEGRATOR_COUNT; i++) {
            print_error(row_at(found, static_cast<arm_integrator>(i), force, step_ms, substeps).tool_m);
        }
        std::printf("\n");
    };
    for (const double step_ms : accuracy_steps_ms) {
        print_row(step_ms, 1);
        if (step_ms == measured.step_ms && measured.arm.config.substeps > 1) {
            print_row(step_ms, measured.arm.config.substeps);
        }
    }
}

void print_drifts(const measured_arm &measured, const accuracy &found)
{
    if (found.drifts.empty()) {
        std::printf("\nmomentum: not kept, for the base is held and its mount takes what it must\n");
        return;
    }
    std::printf("\nspurious momentum of the steps in 60 s of the same motion without contact, in steps of %g ms\n",
                measured.step_ms / static_cast<double>(measured.arm.config.substeps));
    for (int i = 0; i < ARM_INTEGRATOR_COUNT; i++) {
        const momentum_drift &drift = found.drifts[static_cast<std::size_t>(i)];
        std::printf("  %-20s %.1e N s and %.1e N m s, of %.3g N s that the joints move\n",
                    name_of(static_cast<arm_integrator>(i)), drift.linear_N_s, drift.angular_N_m_s, drift.moved_N_s);
    }
}

/* Where the step is too coarse: how many substeps an arm file has to ask for, or how fast the loop has to be. */
void print_advice(const measured_arm &measured, const accuracy &found, double repeatability_um)
{
    const int own = static_cast<int>(measured.arm.config.substeps);
    const auto integrator = static_cast<arm_integrator>(measured.arm.config.integrator);
    std::printf("the integrator's is more than the repeatability; ");
    if (found.enough) {
        std::printf("substeps = %d in the arm's file, which has %d, make it %.3g um\n",
                    static_cast<int>(found.enough->substeps), own, 1e6 * found.enough->tool_m);
        return;
    }
    double enough_ms = 0.0;
    for (const double step_ms : accuracy_steps_ms) {
        const double tool_um = 1e6 * row_at(found, integrator, berthing_force::mean, step_ms, 1).tool_m;
        enough_ms = step_ms < measured.step_ms && tool_um <= repeatability_um ? step_ms : enough_ms;
    }
    if (enough_ms > 0.0) {
        std::printf(
            "more substeps than the %d of the arm's file do not bring it within, for the force is one over the "
            "whole step; a loop of %g ms does\n",
            own, enough_ms);
    } else {
        std::printf(
            "neither more substeps than the %d of the arm's file nor any step of the table bring it within\n", own);
    }
}

void print_verdict(const measured_arm &measured, const accuracy &found, double repeatability_um)
{
    const arm_config &arm = measured.arm.config;
    std::printf("\nat %g ms%s with %s the worst error of the tool, against a robot's repeatability of %g um, and of "
                "force and energy\n",
                measured.step_ms,
                arm.substeps > 1 ? (" in " + std::to_string(arm.substeps) + " substeps").c_str() : "",
                name_of(static_cast<arm_integrator>(arm.integrator)), repeatability_um);
    constexpr std::array forces = {berthing_force::mean, berthing_force::held, berthing_force::led};
    constexpr std::array whats = {"the integrator alone", "held over the step", "led by half a step"};
    for (std::size_t i = 0; i < forces.size(); i++) {
        const accuracy_row &row = own_row(measured, found, forces[i]);
        const double tool_um = 1e6 * row.tool_m;
        char force[64] = "force given";
        if (forces[i] != berthing_force::mean) {
            std::snprintf(force, sizeof force, "%.3g N of %.4g N", row.force_N, found.force_N);
        }
        const std::string what =
            whats[i] + std::string(forces[i] == own_force(measured) ? ", as the loop does" : "");
        std::printf("  %-38s %8.3g um, %s %%; %s, %.3g J of %.4g J\n", what.c_str(), tool_um,
                    percent_text(100.0 * tool_um / repeatability_um).c_str(), force, row.energy_J, found.energy_J);
    }
    if (!(1e6 * own_row(measured, found, berthing_force::mean).tool_m <= repeatability_um)) {
        print_advice(measured, found, repeatability_um);
    }
}

void print_report(const measured_arm &measured, const accuracy &found, double repeatability_um)
{
    std::printf("%s: berthing of 60 s with %d touches and releases, up to %.4g N and %.4g J; the truth is known to "
                "%.0e um\n",
                measured.arm.name.c_str(), found.events, found.force_N, found.energy_J, 1e6 * found.truth_m);
    for (const berthing_force force : {berthing_force::mean, berthing_force::held, berthing_force::led}) {
        print_table(measured, found, force);
    }
    print_drifts(measured, found);
    for (const std::string &beyond : beyond_limits(measured.arm.config, measured.plan)) {
        std::printf("\nlimits are left out here, and a run would keep them: %s\n", beyond.c_str());
    }
    print_verdict(measured, found, repeatability_um);
}

bool names_rig(const std::string &name_or_path)
{
    const auto is_it = [&](const shipped_file &file) { return name_or_path == file.name; };
    const auto &arms = shipped_arms();
    const auto &rigs = shipped_rigs();
    if (std::any_of(arms.begin(), arms.end(), is_it)) {
        return false;
    }
    return std::any_of(rigs.begin(), rigs.end(), is_it) ||
           (looks_like_path(name_or_path) &&
            !parse_toml(read_arm_file(name_or_path), name_or_path).contains("kind"));
}

measured_arm measured_for(const std::string &name_or_path, const std::vector<std::string> &overrides)
{
    if (!names_rig(name_or_path)) {
        if (!overrides.empty()) {
            throw input_error("--set: goes with a rig; " + name_or_path + " is an arm");
        }
        const arm_description arm = load_arm(name_or_path);
        return {arm, print_arm(arm, "manipulator.arm"), {}, reference_step_ms};
    }
    const rig rig = load_rig(name_or_path, overrides);
    if (rig.firmware.arm.kind == ARM_NONE) {
        throw input_error(name_or_path + ": manipulator.arm: is missing; accuracy is about an arm");
    }
    refuse_beam(rig);
    measured_arm measured;
    measured.arm.name = rig.name;
    measured.arm.config = rig.firmware.arm;
    measured.text = rig.arm_text;
    measured.step_ms = 1e-6 * static_cast<double>(config_period_ns(&rig.firmware));
    const manipulator_config &manipulator = rig.firmware.manipulator;
    measured.plan.direction =
        Eigen::Vector3d(manipulator.direction_x, manipulator.direction_y, manipulator.direction_z).normalized();
    measured.plan.mass_kg = rig.object.mass_kg;
    measured.plan.stiffness_N_per_m = rig.object.stiffness_N_per_m;
    measured.plan.damping_N_s_per_m = rig.object.damping_N_s_per_m;
    return measured;
}

/* Whose row the verdict is about. */
double step_for(const accuracy_arguments &arguments, const measured_arm &measured)
{
    const double wanted_ms = arguments.step_ms.value_or(measured.step_ms);
    const auto *const step_ms = std::find_if(accuracy_steps_ms.begin(), accuracy_steps_ms.end(), [&](double known) {
        return std::abs(known - wanted_ms) < 1e-9 * known;
    });
    if (step_ms != accuracy_steps_ms.end()) {
        return *step_ms;
    }
    std::string steps;
    for (const double known : accuracy_steps_ms) {
        char text[32];
        std::snprintf(text, sizeof text, "%s%g", steps.empty() ? "" : ", ", known);
        steps += text;
    }
    if (arguments.step_ms) {
        throw input_error("--step-ms: must be one of " + steps);
    }
    char text[200];
    std::snprintf(text, sizeof text,
                  "loop.rate_Hz: its period of %g ms is none of the steps that are compared; choose one near it "
                  "with --step-ms: ",
                  wanted_ms);
    throw input_error(arguments.arm + ": " + text + steps);
}

accuracy found_for(const accuracy_arguments &arguments, const measured_arm &measured)
try {
    const progress_line progress;
    const accuracy_question question = {measured.step_ms, 1e-6 * arguments.repeatability_um};
    accuracy found = find_accuracy(measured.arm.config, measured.plan, question, [&](double share) {
        progress.show("accuracy: " + std::to_string(static_cast<int>(100.0 * share)) + " %");
    });
    progress.show("");
    return found;
} catch (const input_error &error) {
    throw input_error(arguments.arm + ": " + error.what());
}

} // namespace

int accuracy_command(const accuracy_arguments &arguments)
{
    measured_arm measured = measured_for(arguments.arm, arguments.overrides);
    measured.step_ms = step_for(arguments, measured);
    const arm_config &arm = measured.arm.config;
    if (std::any_of(std::begin(arm.gravity_m_per_s2), std::end(arm.gravity_m_per_s2),
                    [](double part) { return part != 0.0; })) {
        throw input_error(arguments.arm +
                          ": base.gravity_m_per_s2: the manoeuvre is one in orbit, and under gravity a "
                          "free satellite falls out of every number; leave gravity out");
    }
    const accuracy found = found_for(arguments, measured);
    if (arguments.json) {
        print_json(as_json(measured, found, arguments));
    } else {
        print_report(measured, found, arguments.repeatability_um);
    }
    return 0;
}

} // namespace berth
