#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../../hal/rig/arm_file.h"
#include "../effects/active.h"
#include "../stability/loop_timeline.h"
#include "commands.h"
#include "number.h"
#include "progress_line.h"
#include "reduce_amplitude.h"
#include "reduction_report.h"
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
        const char *end = nullptr;
        values(i) = number_at<double>(at, &end);
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
        const char *end = nullptr;
        const long value = number_at<long>(at, &end);
        is_fine = is_fine && end != at;
        at = end;
        return value;
    };
    const auto angle = [&] {
        const char *end = nullptr;
        const double value = number_at<double>(at, &end);
        is_fine = is_fine && end != at && std::fabs(value) <= ARM_ANGLE_MAX_rad;
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
    if (!is_fine || *at != '\0' || joint < 1 || joint > joints || count < 2 || count > 1000 ||
        sweep.from_rad == sweep.to_rad) {
        throw input_error("--sweep " + text + ": must be JOINT=FROM:TO:COUNT with a joint from 1 to " +
                          std::to_string(joints) + ", two angles in rad, within 1e6, and a count from 2 to 1000");
    }
    sweep.joint = joint - 1;
    sweep.count = static_cast<int>(count);
    return sweep;
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
           arguments.is_held || arguments.is_guided;
}

Eigen::VectorXd direction_of(const std::string &text, Eigen::Index dimensions)
{
    Eigen::VectorXd direction = numbers_of("--direction", text, dimensions);
    /* Beyond, its square is 0 or inf. */
    if (!(direction.norm() >= 1e-12 && direction.norm() <= 1e12)) {
        throw input_error("--direction " + text + ": has no direction");
    }
    return direction;
}

reduction_choice choice_for(const reduce_arguments &arguments, const rig &rig, const arm_config &arm)
{
    reduction_choice choice = choice_at_start(rig, arm);
    if (arguments.is_guided && rig.has_side_axes()) {
        throw input_error("--guided: [axis.*] shows where the tool goes across; leave one of them out");
    }
    choice.is_guided = arguments.is_guided;
    if (!arguments.direction.empty()) {
        choice.direction = direction_of(arguments.direction, choice.direction.size());
    }
    if (!arguments.pose.empty()) {
        choice.pose_rad = numbers_of("--pose", arguments.pose, arm.joint_count);
        if (choice.pose_rad.cwiseAbs().maxCoeff() > ARM_ANGLE_MAX_rad) {
            throw input_error("--pose " + arguments.pose + ": angles must be within 1e6 rad");
        }
    }
    return choice;
}

/* What is told of a rig, in JSON. */
struct told {
    std::vector<std::string> left_out;
    nlohmann::json arm;
    nlohmann::json direction;
    nlohmann::json is_guided;
    nlohmann::json is_base_free;
    nlohmann::json poses = nlohmann::json::array();
    nlohmann::json amplitudes;
    nlohmann::json object;
};

/* A pose takes a second at 200 periods, 3 s at 400 and minutes at 2000: its limits are looked for with some hundred
 * loops, each with a state for every period of dead time. */
constexpr double dead_time_max_periods = 400.0;

void check_dead_time(const rig &rig)
{
    const double most_ms = dead_time_max_periods * 1e3 * config_period_s(&rig.firmware);
    if (rig.robot.dead_time_ms > most_ms) {
        char text[160];
        std::snprintf(text, sizeof text,
                      "robot.dead_time_ms: %g ms is more than %g periods (%g ms), beyond which the limits would "
                      "take minutes; `berth eigen` takes it",
                      rig.robot.dead_time_ms, dead_time_max_periods, most_ms);
        throw input_error(text);
    }
}

void leave_out(told &result, const std::string &what)
{
    std::fprintf(stderr, "berth: %s\n", what.c_str());
    result.left_out.push_back(what);
}

/* The rig as a loop that is the same in every period, of which alone there are eigenvalues. */
rig steady_part(const rig &rig, told &result)
{
    for (const std::string &line : left_out_of_reduction(rig)) {
        leave_out(result, line);
    }
    if (!is_time_varying(rig)) {
        return rig;
    }
    for (const std::string &line : what_varies(rig, load_wake_histogram(rig))) {
        leave_out(result, line + ": changes the loop from period to period; left out");
    }
    return without_variation(rig);
}

void look_at_pose(const reduce_arguments &arguments, const rig &rig, const arm_description &arm,
                  const reduction_choice &choice, told &result)
{
    const reduction found = reduce(rig, arm.config, choice);
    result.poses.push_back(as_json(choice.pose_rad, found));
    std::optional<amplitude_result> by_amplitude;
    if (!arguments.amplitudes.empty()) {
        by_amplitude = look_at_amplitudes(arm.config, choice, rig, found, amplitudes_of(arguments.amplitudes));
        result.amplitudes = as_json(*by_amplitude);
    }
    if (arguments.json) {
        return;
    }
    std::printf("%s in the loop of %s, at %s rad, %s\n", arm.name.c_str(), rig.name.c_str(),
                text_of(choice.pose_rad).c_str(), conditions_text(arm.config, choice).c_str());
    if (by_amplitude) {
        print_amplitudes(*by_amplitude);
    } else {
        print_reduction(found);
    }
}

void sweep_a_joint(const reduce_arguments &arguments, const rig &rig, const arm_description &arm,
                   reduction_choice choice, told &result)
{
    if (!arguments.amplitudes.empty()) {
        throw input_error("--amplitude: is about one pose; leave --sweep out");
    }
    const pose_sweep sweep = sweep_of(arguments.sweep, arm.config.joint_count);
    if (!arguments.json) {
        std::printf("%s in the loop of %s, joint %d from pose to pose, %s\n", arm.name.c_str(), rig.name.c_str(),
                    static_cast<int>(sweep.joint) + 1, conditions_text(arm.config, choice).c_str());
        print_sweep_head();
    }
    const progress_line progress;
    for (int i = 0; i < sweep.count; i++) {
        if (arguments.json) { /* else the rows show how far it is */
            progress.show("reduce: pose " + std::to_string(i + 1) + " of " + std::to_string(sweep.count));
        }
        const double angle_rad = sweep.from_rad + (sweep.to_rad - sweep.from_rad) * i / (sweep.count - 1);
        choice.pose_rad(sweep.joint) = angle_rad;
        try {
            const reduction found = reduce(rig, arm.config, choice);
            result.poses.push_back(as_json(choice.pose_rad, found));
            if (!arguments.json) {
                print_sweep_row(angle_rad, found);
            }
        } catch (const nothing_springy &) {
            result.poses.push_back(no_reduction_json(choice.pose_rad));
            if (!arguments.json) {
                std::printf("  %9.3f  no spring of the arm moves the tool along the direction\n", angle_rad);
            }
        }
    }
}

void look_at_arm(const reduce_arguments &arguments, const rig &rig, told &result)
{
    arm_description arm = arm_for(arguments, rig);
    if (arguments.is_held) {
        arm.config.base_is_free = 0;
        arm.config.attitude.actuator = ATTITUDE_NONE;
    }
    for (const std::string &line : attitude_left_out_without_ticks(arm.config, config_period_s(&rig.firmware))) {
        leave_out(result, line);
    }
    const reduction_choice choice = choice_for(arguments, rig, arm.config);
    result.arm = arm.name;
    result.direction = std::vector<double>(choice.direction.begin(), choice.direction.end());
    result.is_guided = choice.is_guided;
    result.is_base_free = arm.config.base_is_free != 0;
    if (arguments.sweep.empty()) {
        look_at_pose(arguments, rig, arm, choice, result);
    } else {
        sweep_a_joint(arguments, rig, arm, choice, result);
    }
}

} // namespace

int reduce_command(const reduce_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    check_dead_time(chosen.rig);
    if (chosen.rig.object.kind == object_kind::contact) {
        throw input_error(
            "object.kind: one-sided contact has no small motions, and so nothing to reduce to; look at a gripped "
            "object of the same stiffness, object.kind = \"gripped\"");
    }
    told result;
    const rig rig = steady_part(chosen.rig, result);
    if (rig.object.kind == object_kind::beam) {
        const object_reduction found = reduce_object(rig);
        result.object = as_json(found);
        if (!arguments.json) {
            print_object(rig, found);
        }
    }
    if (rig.object.kind != object_kind::beam || asks_for_arm(arguments, rig)) {
        look_at_arm(arguments, rig, result);
    }
    const std::vector<std::string> compared = what_is_compared(rig);
    if (arguments.json) {
        print_json({{"rig", rig.name},
                    {"arm", result.arm},
                    {"direction", result.direction},
                    {"guided", result.is_guided},
                    {"base_free", result.is_base_free},
                    {"left_out", result.left_out},
                    {"compared", compared},
                    {"poses", result.poses},
                    {"amplitudes", result.amplitudes},
                    {"object", result.object}});
    } else {
        for (const std::string &line : compared) {
            std::printf("  %s\n", line.c_str());
        }
    }
    return 0;
}

} // namespace berth
