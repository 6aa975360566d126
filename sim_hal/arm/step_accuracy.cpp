#include "step_accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "../../hal/rig/beam.h"
#include "../../hal/rig/rig_file.h"
#include "berthing.h"

namespace berth
{

namespace
{

/* Beyond this the steps have blown up; a tool is nowhere near it. */
constexpr double lost_m = 1.0;

berthing_plan plan_of(const rig &rig, double period_s)
{
    const manipulator_config &manipulator = rig.firmware.manipulator;
    const beam_mode object = object_mode(rig.object, 0);
    berthing_plan plan;
    plan.direction =
        Eigen::Vector3d(manipulator.direction_x, manipulator.direction_y, manipulator.direction_z).normalized();
    plan.mass_kg = object.mass_kg;
    plan.stiffness_N_per_m = object.stiffness_N_per_m;
    plan.damping_N_s_per_m = object.damping_N_s_per_m;
    plan.command_period_s = period_s * std::max(1.0, std::round(plan.command_period_s / period_s));
    plan.object_step_s = 0.5 * period_s;
    return plan;
}

double distance_m(const std::vector<berthing_sample> &coarse, const std::vector<berthing_sample> &fine)
{
    double largest_m = 0.0;
    for (std::size_t i = 0; i < coarse.size(); i++) {
        const double apart_m = (coarse[i].tool_m - fine[i].tool_m).norm();
        if (!(apart_m < lost_m)) {
            return std::numeric_limits<double>::infinity();
        }
        largest_m = std::max(largest_m, apart_m);
    }
    return largest_m;
}

} // namespace

std::optional<bool> step_accuracy::is_accurate() const
{
    return tool_m ? std::optional<bool>(*tool_m <= usual_repeatability_m) : std::nullopt;
}

step_accuracy estimate_accuracy(const rig &rig)
try {
    const arm_config &arm = rig.firmware.arm;
    const double period_s = config_period_s(&rig.firmware);
    const auto has_gravity = [](double part_m_per_s2) { return part_m_per_s2 != 0.0; };
    if (std::any_of(std::begin(arm.gravity_m_per_s2), std::end(arm.gravity_m_per_s2), has_gravity)) {
        return {1e3 * period_s, {}, "the manoeuvre that tells it is one in orbit, and the arm has gravity"};
    }
    const berthing_plan plan = plan_of(rig, period_s);
    /* The force lead of the compensation leads it to the middle of the tick, too. */
    const bool is_led = config_leads_force(&rig.firmware) != 0 || rig.firmware.force_lead.enabled != 0;
    const berthing_force force = is_led ? berthing_force::led : berthing_force::held;
    const auto in_steps_of = [&](double step_s) {
        return stepped_berthing(arm, plan, static_cast<arm_integrator>(arm.integrator), {step_s, arm.substeps},
                                force, {});
    };
    return {1e3 * period_s, 2.0 * distance_m(in_steps_of(period_s), in_steps_of(0.5 * period_s)), ""};
} catch (const input_error &error) {
    return {1e3 * config_period_s(&rig.firmware), {}, error.what()};
}

std::string accuracy_sentence(const step_accuracy &accuracy, const rig &rig)
{
    if (!accuracy.tool_m) {
        return "not known: " + accuracy.why_unknown;
    }
    const double share = *accuracy.tool_m / usual_repeatability_m;
    std::array<char, 200> text{};
    if (std::isfinite(share)) {
        std::snprintf(
            text.data(), text.size(),
            "%saccurate: steps of %g ms put the tool about %.2g um off in a berthing of 60 s, %.2g times a "
            "robot's repeatability of %g um",
            share <= 1.0 ? "" : "NOT ", accuracy.step_ms, 1e6 * *accuracy.tool_m, share,
            1e6 * usual_repeatability_m);
    } else {
        std::snprintf(text.data(), text.size(), "NOT accurate: in a berthing of 60 s steps of %g ms blow up",
                      accuracy.step_ms);
    }
    const arm_config &arm = rig.firmware.arm;
    if (share <= 1.0) {
        return text.data();
    }
    return text.data() +
           std::string(arm.force != arm_force_for(arm.integrator)
                           ? "; the arm's file sets a force that does not suit its integrator: leave "
                             "the key out"
                           : "; set substeps in the arm's file or a faster loop, `berth accuracy` says "
                             "which");
}

} // namespace berth
