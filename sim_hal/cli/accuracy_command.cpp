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
                                       "as the loop does: the force at a step's begin held over it",
                                       "that force led by half a step"};

/* Beyond this the steps have blown up; a tool is nowhere near it. */
constexpr double lost_m = 1.0;

const char *name_of(arm_integrator integrator)
{
    return integrator_names[static_cast<std::size_t>(integrator)];
}

const accuracy_row &row_at(const accuracy &found, arm_integrator integrator, berthing_force force, double step_ms)
{
    return *std::find_if(found.rows.begin(), found.rows.end(), [&](const accuracy_row &row) {
        return row.integrator == integrator && row.force == force && row.step_ms == step_ms;
    });
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
};

nlohmann::json as_json(const measured_arm &measured, const accuracy &found, const accuracy_arguments &arguments)
{
    const arm_description &arm = measured.arm;
    nlohmann::json rows = nlohmann::json::array();
    for (const accuracy_row &row : found.rows) {
        nlohmann::json entry = {{"integrator", name_of(row.integrator)},
                                {"force", force_names[static_cast<std::size_t>(row.force)]},
                                {"step_ms", row.step_ms},
                                {"tool_m", finite(row.tool_m)},
                                {"energy_J", finite(row.energy_J)}};
        if (row.force != berthing_force::mean) {
            entry["force_N"] = finite(row.force_N);
        }
        rows.push_back(entry);
    }
    nlohmann::json drifts;
    for (int i = 0; i < ARM_INTEGRATOR_COUNT; i++) {
        const momentum_drift &drift = found.drifts[static_cast<std::size_t>(i)];
        drifts[name_of(static_cast<arm_integrator>(i))] = {{"angular_N_m_s", finite(drift.angular_N_m_s)},
                                                           {"linear_N_s", finite(drift.linear_N_s)},
                                                           {"moved_N_s", finite(drift.moved_N_s)}};
    }
    const auto integrator = static_cast<arm_integrator>(arm.config.integrator);
    return {{"arm", arm.name},
            {"arm_hash", text_hash(measured.text)},
            {"integrator", name_of(integrator)},
            {"step_ms", arguments.step_ms},
            {"repeatability_m", 1e-6 * arguments.repeatability_um},
            {"tool_m", finite(row_at(found, integrator, berthing_force::mean, arguments.step_ms).tool_m)},
            {"held_tool_m", finite(row_at(found, integrator, berthing_force::held, arguments.step_ms).tool_m)},
            {"led_tool_m", finite(row_at(found, integrator, berthing_force::led, arguments.step_ms).tool_m)},
            {"truth_m", found.truth_m},
            {"events", found.events},
            {"largest_force_N", found.force_N},
            {"largest_energy_J", found.energy_J},
            {"rows", rows},
            {"momentum_drift", drifts}};
}

void print_error(double tool_m)
{
    if (tool_m < lost_m) {
        std::printf(" %20.4g", 1e6 * tool_m);
    } else {
        std::printf(" %20s", "unstable");
    }
}

void print_table(const accuracy &found, berthing_force force)
{
    std::printf("\nlargest error of the tool in um; %s\n  %8s", force_meanings[static_cast<std::size_t>(force)],
                "step ms");
    for (const char *const name : integrator_names) {
        std::printf(" %20s", name);
    }
    std::printf("\n");
    for (const double step_ms : accuracy_steps_ms) {
        std::printf("  %8g", step_ms);
        for (int i = 0; i < ARM_INTEGRATOR_COUNT; i++) {
            print_error(row_at(found, static_cast<arm_integrator>(i), force, step_ms).tool_m);
        }
        std::printf("\n");
    }
}

/* Where the step is too coarse, how many an arm file has to ask for. */
void print_advice(const accuracy &found, arm_integrator integrator, const accuracy_arguments &arguments)
{
    double enough_ms = 0.0;
    for (const double step_ms : accuracy_steps_ms) {
        const accuracy_row &row = row_at(found, integrator, berthing_force::mean, step_ms);
        if (step_ms <= arguments.step_ms && 1e6 * row.tool_m <= arguments.repeatability_um) {
            enough_ms = std::max(enough_ms, step_ms);
        }
    }
    if (enough_ms > 0.0) {
        std::printf("that is more than the repeatability; steps of %g ms keep within it: substeps = %d in the arm's "
                    "file\n",
                    enough_ms, static_cast<int>(std::ceil(arguments.step_ms / enough_ms)));
    } else {
        std::printf("that is more than the repeatability, and so is what any step of the table makes\n");
    }
}

void print_report(const arm_description &arm, const accuracy &found, const accuracy_arguments &arguments)
{
    std::printf("%s: berthing of 60 s with %d touches and releases, up to %.4g N and %.4g J; the truth is known to "
                "%.0e um\n",
                arm.name.c_str(), found.events, found.force_N, found.energy_J, 1e6 * found.truth_m);
    for (const berthing_force force : {berthing_force::mean, berthing_force::held, berthing_force::led}) {
        print_table(found, force);
    }
    std::printf("\nmomentum that comes of nothing in 60 s of the same motion without contact, at 2.5 ms\n");
    for (int i = 0; i < ARM_INTEGRATOR_COUNT; i++) {
        const momentum_drift &drift = found.drifts[static_cast<std::size_t>(i)];
        std::printf("  %-20s %.1e N s and %.1e N m s, of %.3g N s that the joints move\n",
                    name_of(static_cast<arm_integrator>(i)), drift.linear_N_s, drift.angular_N_m_s, drift.moved_N_s);
    }
    const auto integrator = static_cast<arm_integrator>(arm.config.integrator);
    const auto tool_um = [&](berthing_force force) {
        return 1e6 * row_at(found, integrator, force, arguments.step_ms).tool_m;
    };
    const double alone_um = tool_um(berthing_force::mean);
    std::printf("\nat %g ms with %s the worst error of the tool is %.3g um, %.2g %% of a robot's repeatability of "
                "%g um; with the force held over the step %.3g um, with it led by half a step %.3g um\n",
                arguments.step_ms, name_of(integrator), alone_um, 100.0 * alone_um / arguments.repeatability_um,
                arguments.repeatability_um, tool_um(berthing_force::held), tool_um(berthing_force::led));
    if (alone_um > arguments.repeatability_um) {
        print_advice(found, integrator, arguments);
    }
    std::printf("worst error of force and energy there:\n");
    for (const berthing_force force : {berthing_force::mean, berthing_force::held, berthing_force::led}) {
        const accuracy_row &row = row_at(found, integrator, force, arguments.step_ms);
        const char *const what = force == berthing_force::mean   ? "the integrator alone"
                                 : force == berthing_force::held ? "held over the step"
                                                                 : "led by half a step";
        if (force == berthing_force::mean) {
            std::printf("  %-22s force given, %.3g J of %.4g J\n", what, row.energy_J, found.energy_J);
        } else {
            std::printf("  %-22s %.3g N of %.4g N, %.3g J of %.4g J\n", what, row.force_N, found.force_N,
                        row.energy_J, found.energy_J);
        }
    }
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
           (looks_like_path(name_or_path) && !parse_toml(read_file(name_or_path), name_or_path).contains("kind"));
}

measured_arm measured_for(const std::string &name_or_path, const std::vector<std::string> &overrides)
{
    if (!names_rig(name_or_path)) {
        if (!overrides.empty()) {
            throw input_error("--set: goes with a rig; " + name_or_path + " is an arm");
        }
        const arm_description arm = load_arm(name_or_path);
        return {arm, print_arm(arm, "manipulator.arm"), {}};
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
    const manipulator_config &manipulator = rig.firmware.manipulator;
    measured.plan.direction =
        Eigen::Vector3d(manipulator.direction_x, manipulator.direction_y, manipulator.direction_z).normalized();
    measured.plan.mass_kg = rig.object.mass_kg;
    measured.plan.stiffness_N_per_m = rig.object.stiffness_N_per_m;
    measured.plan.damping_N_s_per_m = rig.object.damping_N_s_per_m;
    return measured;
}

} // namespace

int accuracy_command(const accuracy_arguments &arguments)
{
    const measured_arm measured = measured_for(arguments.arm, arguments.overrides);
    const arm_config &arm = measured.arm.config;
    if (std::any_of(std::begin(arm.gravity_m_per_s2), std::end(arm.gravity_m_per_s2),
                    [](double part) { return part != 0.0; })) {
        throw input_error(arguments.arm +
                          ": base.gravity_m_per_s2: the manoeuvre is one in orbit, and under gravity a "
                          "free satellite falls out of every number; leave gravity out");
    }
    if (std::find(accuracy_steps_ms.begin(), accuracy_steps_ms.end(), arguments.step_ms) ==
        accuracy_steps_ms.end()) {
        std::string steps;
        for (const double step_ms : accuracy_steps_ms) {
            char text[32];
            std::snprintf(text, sizeof text, "%s%g", steps.empty() ? "" : ", ", step_ms);
            steps += text;
        }
        throw input_error("--step-ms: must be one of " + steps);
    }
    const progress_line progress;
    const accuracy found = find_accuracy(measured.arm.config, measured.plan, [&](double share) {
        progress.show("accuracy: " + std::to_string(static_cast<int>(100.0 * share)) + " %");
    });
    progress.show("");
    if (arguments.json) {
        print_json(as_json(measured, found, arguments));
    } else {
        print_report(measured.arm, found, arguments);
    }
    return 0;
}

} // namespace berth
