#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "../../hal/rig/arm_file.h"
#include "../effects/active.h"
#include "../stability/reduction.h"
#include "commands.h"
#include "reduce_amplitude.h"
#include "robot_choice.h"

namespace berth
{

namespace
{

/* "1.2,-0.4": as many numbers as that. */
Eigen::VectorXd numbers_of(const std::string &option, const std::string &text, Eigen::Index count)
{
    Eigen::VectorXd values(count);
    const char *at = text.c_str();
    for (Eigen::Index i = 0; i < count; i++) {
        char *end = nullptr;
        values(i) = std::strtod(at, &end);
        const char separator = i + 1 < count ? ',' : '\0';
        if (end == at || *end != separator || !std::isfinite(values(i))) {
            throw input_error(std::string(option).append(" ").append(text) + ": must be " + std::to_string(count) +
                              " numbers with commas between them");
        }
        at = end + 1;
    }
    return values;
}

/* "2=-2.5:-0.3:20" */
struct pose_sweep {
    Eigen::Index joint = 0;
    double from_rad = 0.0;
    double to_rad = 0.0;
    int count = 0;
};

pose_sweep sweep_of(const std::string &text, Eigen::Index joints)
{
    const char *at = text.c_str();
    bool is_fine = true;
    const auto pass = [&](char separator) {
        is_fine = is_fine && *at == separator;
        at += *at != '\0' ? 1 : 0;
    };
    const auto whole = [&] {
        char *end = nullptr;
        const long value = std::strtol(at, &end, 10);
        is_fine = is_fine && end != at;
        at = end;
        return value;
    };
    const auto angle = [&] {
        char *end = nullptr;
        const double value = std::strtod(at, &end);
        is_fine = is_fine && end != at && std::isfinite(value);
        at = end;
        return value;
    };
    pose_sweep sweep;
    const long joint = whole();
    pass('=');
    sweep.from_rad = angle();
    pass(':');
    sweep.to_rad = angle();
    pass(':');
    const long count = whole();
    if (!is_fine || *at != '\0' || joint < 1 || joint > joints || count < 2 || count > 1000) {
        throw input_error("--sweep " + text + ": must be JOINT=FROM:TO:COUNT with a joint from 1 to " +
                          std::to_string(joints) + ", angles in rad and a count from 2 to 1000");
    }
    sweep.joint = joint - 1;
    sweep.count = static_cast<int>(count);
    return sweep;
}

nlohmann::json as_json(const arm_mode &mode)
{
    return {{"frequency_Hz", mode.frequency_Hz},
            {"damping_ratio", mode.damping_ratio},
            {"share", mode.share},
            {"mass_kg", mode.mass_kg},
            {"damping_N_s_per_m", mode.damping_N_s_per_m},
            {"stiffness_N_per_m", mode.stiffness_N_per_m}};
}

nlohmann::json as_json(const swing &swing)
{
    return {{"frequency_Hz", swing.frequency_Hz}, {"damping_ratio", swing.damping_ratio}};
}

nlohmann::json as_json(const std::optional<swing> &swing)
{
    return swing ? as_json(*swing) : nlohmann::json();
}

nlohmann::json as_json(const arm_loop_growth &growth)
{
    return {{"spectral_radius", growth.spectral_radius},
            {"growth_per_s", growth.growth_per_s},
            {"frequency_Hz", growth.frequency_Hz}};
}

nlohmann::json as_json(const std::optional<double> &limit)
{
    return limit ? nlohmann::json(*limit) : nlohmann::json();
}

nlohmann::json as_json(const dead_time_limits &limits)
{
    return {{"reduced", as_json(limits.reduced_ms)},
            {"full", as_json(limits.full_ms)},
            {"looked_to", limits.looked_to_ms}};
}

nlohmann::json as_json(const Eigen::VectorXd &pose_rad, const reduction &found)
{
    nlohmann::json modes = nlohmann::json::array();
    for (const arm_mode &mode : found.modes) {
        modes.push_back(as_json(mode));
    }
    return {{"pose_rad", std::vector<double>(pose_rad.begin(), pose_rad.end())},
            {"reduced", as_json(found.reduced)},
            {"modes", modes},
            {"coupled", {{"reduced", as_json(found.coupled_reduced)}, {"full", as_json(found.coupled_full)}}},
            {"loop", {{"reduced", as_json(found.loop_reduced)}, {"full", as_json(found.loop_full)}}},
            {"object_limit",
             {{"reduced", as_json(found.object_limit_reduced)}, {"full", as_json(found.object_limit_full)}}},
            {"dead_time_limit_ms", as_json(found.dead_time)}};
}

nlohmann::json as_json(const object_reduction &found)
{
    nlohmann::json modes = nlohmann::json::array();
    for (const beam_mode &mode : found.modes) {
        modes.push_back({{"frequency_Hz", mode.frequency_Hz},
                         {"mass_kg", mode.mass_kg},
                         {"damping_N_s_per_m", mode.damping_N_s_per_m},
                         {"stiffness_N_per_m", mode.stiffness_N_per_m}});
    }
    return {{"reduced", modes.front()},
            {"modes", modes},
            {"compliance_share", found.compliance_share},
            {"coupled", {{"reduced", as_json(found.coupled_reduced)}, {"full", as_json(found.coupled_full)}}},
            {"loop", {{"reduced", as_json(found.loop_reduced)}, {"full", as_json(found.loop_full)}}},
            {"object_limit",
             {{"reduced", as_json(found.object_limit_reduced)}, {"full", as_json(found.object_limit_full)}}},
            {"dead_time_limit_ms", as_json(found.dead_time)}};
}

std::string limit_text(const std::optional<double> &factor)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", factor.value_or(0.0));
    return factor ? text : "> 1e4";
}

/* What an arm's and a beam's reduction have in common. */
template <typename reduction_type>
void print_comparison(const char *full_title, const char *coupled_title, const reduction_type &found)
{
    const auto line = [](const char *what, const std::string &reduced, const std::string &full) {
        std::printf("  %-44s %12s %12s\n", what, reduced.c_str(), full.c_str());
    };
    const auto text = [](const char *format, double value) {
        char buffer[32];
        std::snprintf(buffer, sizeof buffer, format, value);
        return std::string(buffer);
    };
    line("", "reduced", full_title);
    const std::optional<swing> full = found.coupled_full;
    line(coupled_title, text("%.4f", found.coupled_reduced.frequency_Hz),
         full ? text("%.4f", full->frequency_Hz) : "none near");
    line("  damping ratio", text("%.5f", found.coupled_reduced.damping_ratio),
         full ? text("%.5f", full->damping_ratio) : "");
    line("in the loop: growth /s", text("%+.5f", found.loop_reduced.growth_per_s),
         text("%+.5f", found.loop_full.growth_per_s));
    line("  of a mode at Hz", text("%.4f", found.loop_reduced.frequency_Hz),
         text("%.4f", found.loop_full.frequency_Hz));
    line("object may be stiffer by the factor", limit_text(found.object_limit_reduced),
         limit_text(found.object_limit_full));
    const auto dead_time = [&](const std::optional<double> &limit_ms) {
        return limit_ms ? text(*limit_ms > 0.0 ? "%.4g" : "none", *limit_ms)
                        : text("> %.4g", found.dead_time.looked_to_ms);
    };
    line("robot's dead time may be up to, ms", dead_time(found.dead_time.reduced_ms),
         dead_time(found.dead_time.full_ms));
}

void print_one(const reduction &found)
{
    const arm_mode &r = found.reduced;
    std::printf("  reduced to one degree of freedom: M = %.6g kg, D = %.6g N s/m, K = %.6g N/m (%.4f Hz, damping "
                "ratio %.4f)\n",
                r.mass_kg, r.damping_N_s_per_m, r.stiffness_N_per_m, r.frequency_Hz, r.damping_ratio);
    std::printf("  modes along the direction\n    %10s %10s %10s %12s\n", "Hz", "damping", "share", "mass kg");
    for (const arm_mode &mode : found.modes) {
        std::printf("    %10.4f %10.4f %9.2f%% %12.5g\n", mode.frequency_Hz, mode.damping_ratio, 100.0 * mode.share,
                    mode.mass_kg);
    }
    print_comparison("full arm", "with the object, no dead time: Hz", found);
    if (!found.nearest) {
        std::printf("  %s\n", none_is_near(found.visible, found.coupled_reduced.frequency_Hz).c_str());
    }
}

void print_object(const rig &rig, const object_reduction &found)
{
    const beam_mode &first = found.modes.front();
    std::printf("the beam of %s, %d modes\n", rig.name.c_str(), static_cast<int>(found.modes.size()));
    std::printf(
        "  reduced to one degree of freedom: m = %.6g kg, d = %.6g N s/m, k = %.6g N/m (%.4f Hz), %.2f %% of "
        "the compliance\n",
        first.mass_kg, first.damping_N_s_per_m, first.stiffness_N_per_m, first.frequency_Hz,
        100.0 * found.compliance_share);
    std::printf("  modes at the tip\n    %10s %12s %14s\n", "Hz", "mass kg", "stiffness N/m");
    for (const beam_mode &mode : found.modes) {
        std::printf("    %10.4f %12.5g %14.6g\n", mode.frequency_Hz, mode.mass_kg, mode.stiffness_N_per_m);
    }
    print_comparison("all modes", "with the manipulator, no dead time: Hz", found);
    std::printf("  the first coupled frequency with one mode is off by %+.3f %%\n",
                100.0 * (found.coupled_reduced.frequency_Hz / found.coupled_full.frequency_Hz - 1.0));
}

void print_row(double angle_rad, const reduction &found)
{
    char full_Hz[32] = "none near";
    if (found.coupled_full) {
        std::snprintf(full_Hz, sizeof full_Hz, "%.4f", found.coupled_full->frequency_Hz);
    }
    std::printf("  %9.3f %10.2f %9.4f %7.1f%% %11.4f %11s %11.5f %11.5f %10s %10s\n", angle_rad,
                found.reduced.mass_kg, found.reduced.frequency_Hz, 100.0 * found.reduced.share,
                found.coupled_reduced.frequency_Hz, full_Hz, found.loop_reduced.growth_per_s,
                found.loop_full.growth_per_s, limit_text(found.object_limit_reduced).c_str(),
                limit_text(found.object_limit_full).c_str());
}

/* Nothing at a pose of a sweep at which there is nothing to reduce to. */
std::optional<reduction> reduce_if(bool is_sweep, const rig &rig, const arm_config &arm,
                                   const reduction_choice &choice)
{
    try {
        return reduce(rig, arm, choice);
    } catch (const nothing_springy &) {
        if (!is_sweep) {
            throw;
        }
        return {};
    }
}

nlohmann::json no_reduction_json(const Eigen::VectorXd &pose_rad)
{
    return {{"pose_rad", std::vector<double>(pose_rad.begin(), pose_rad.end())}, {"reduced", nullptr}};
}

arm_description arm_for(const reduce_arguments &arguments, const rig &rig)
{
    if (!arguments.arm.empty() || rig.firmware.arm.kind == ARM_NONE) {
        return load_arm(arguments.arm.empty() ? "ess" : arguments.arm);
    }
    arm_description own;
    own.name = "its arm";
    own.config = rig.firmware.arm;
    return own;
}

/* A beam has a reduction of its own to show. */
bool asks_for_arm(const reduce_arguments &arguments, const rig &rig)
{
    return rig.firmware.arm.kind != ARM_NONE || !arguments.arm.empty() || !arguments.pose.empty() ||
           !arguments.direction.empty() || !arguments.sweep.empty() || !arguments.amplitudes.empty() ||
           arguments.is_held || arguments.is_unguided;
}

Eigen::VectorXd direction_for(const reduce_arguments &arguments, const rig &rig, Eigen::Index dimensions)
{
    if (arguments.direction.empty()) {
        const manipulator_config &manipulator = rig.firmware.manipulator;
        return Eigen::Vector3d(manipulator.direction_x, manipulator.direction_y, manipulator.direction_z)
            .head(dimensions);
    }
    Eigen::VectorXd direction = numbers_of("--direction", arguments.direction, dimensions);
    /* Beyond, its square is 0 or inf. */
    if (!(direction.norm() >= 1e-12 && direction.norm() <= 1e12)) {
        throw input_error("--direction " + arguments.direction + ": has no direction");
    }
    return direction;
}

} // namespace

int reduce_command(const reduce_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    if (chosen.rig.object.kind == object_kind::contact) {
        throw input_error(
            "object.kind: one-sided contact has no small motions, and so nothing to reduce to; look at a gripped "
            "object of the same stiffness, object.kind = \"gripped\"");
    }
    std::vector<std::string> left_out = left_out_of_reduction(chosen.rig);
    for (const std::string &line : left_out) {
        std::fprintf(stderr, "berth: %s\n", line.c_str());
    }
    nlohmann::json object;
    if (chosen.rig.object.kind == object_kind::beam) {
        const object_reduction found = reduce_object(chosen.rig);
        object = as_json(found);
        if (!arguments.json) {
            print_object(chosen.rig, found);
        }
        if (!asks_for_arm(arguments, chosen.rig)) {
            if (arguments.json) {
                print_json({{"rig", chosen.rig.name},
                            {"arm", nullptr},
                            {"left_out", left_out},
                            {"poses", nlohmann::json::array()},
                            {"amplitudes", nullptr},
                            {"object", object}});
            }
            return 0;
        }
    }
    arm_description arm = arm_for(arguments, chosen.rig);
    const Eigen::Index joints = arm.config.joint_count;
    if (arguments.is_held) {
        arm.config.base_is_free = 0;
        arm.config.attitude.actuator = ATTITUDE_NONE;
    }
    if (lacks_thrusters(arm.config)) {
        left_out.emplace_back(thrusters_left_out);
        std::fprintf(stderr, "berth: %s\n", thrusters_left_out);
    }
    reduction_choice choice;
    choice.pose_rad.resize(joints);
    for (Eigen::Index i = 0; i < joints; i++) {
        choice.pose_rad(i) = arm.config.joints[i].initial_rad;
    }
    if (!arguments.pose.empty()) {
        choice.pose_rad = numbers_of("--pose", arguments.pose, joints);
    }
    choice.is_guided = !arguments.is_unguided;
    choice.direction = direction_for(arguments, chosen.rig, arm.config.kind == ARM_PLANAR ? 2 : 3);
    const bool is_sweep = !arguments.sweep.empty();
    const pose_sweep sweep =
        is_sweep ? sweep_of(arguments.sweep, joints) : pose_sweep{0, choice.pose_rad(0), 0.0, 1};
    if (is_sweep && !arguments.amplitudes.empty()) {
        throw input_error("--amplitude: is about one pose; leave --sweep out");
    }
    if (is_sweep && !arguments.json) {
        std::printf("%s in the loop of %s, joint %d from pose to pose; reduced, then full arm\n"
                    "  %9s %10s %9s %8s %23s %23s %21s\n",
                    arm.name.c_str(), chosen.rig.name.c_str(), static_cast<int>(sweep.joint) + 1, "rad", "mass kg",
                    "Hz", "share", "with the object, Hz", "growth in the loop /s", "object may be stiffer");
    }
    nlohmann::json amplitudes;
    nlohmann::json poses = nlohmann::json::array();
    for (int i = 0; i < sweep.count; i++) {
        if (is_sweep) {
            choice.pose_rad(sweep.joint) = sweep.from_rad + (sweep.to_rad - sweep.from_rad) * i / (sweep.count - 1);
        }
        const std::optional<reduction> reducible = reduce_if(is_sweep, chosen.rig, arm.config, choice);
        if (!reducible) {
            poses.push_back(no_reduction_json(choice.pose_rad));
            if (!arguments.json) {
                std::printf("  %9.3f  nothing springy moves the tool along the direction\n",
                            choice.pose_rad(sweep.joint));
            }
            continue;
        }
        const reduction &found = *reducible;
        std::optional<amplitude_result> by_amplitude;
        if (!arguments.amplitudes.empty()) {
            by_amplitude =
                look_at_amplitudes(arm.config, choice, chosen.rig, found, amplitudes_of(arguments.amplitudes));
            amplitudes = as_json(*by_amplitude);
        }
        if (arguments.json) {
            poses.push_back(as_json(choice.pose_rad, found));
        } else if (is_sweep) {
            print_row(choice.pose_rad(sweep.joint), found);
        } else {
            std::printf("%s in the loop of %s\n", arm.name.c_str(), chosen.rig.name.c_str());
            if (by_amplitude) {
                print_amplitudes(*by_amplitude);
            } else {
                print_one(found);
            }
        }
    }
    if (arguments.json) {
        print_json({{"rig", chosen.rig.name},
                    {"arm", arm.name},
                    {"left_out", left_out},
                    {"poses", poses},
                    {"amplitudes", amplitudes},
                    {"object", object}});
    }
    return 0;
}

} // namespace berth
