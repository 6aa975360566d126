#include "reduction_report.h"

#include <cstdio>

namespace berth
{

namespace
{

nlohmann::json as_json(const arm_mode &mode)
{
    return {{"frequency_Hz", mode.frequency_Hz},
            {"damping_ratio", mode.damping_ratio},
            {"share", mode.share},
            {"attitude_share", mode.attitude_share},
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

nlohmann::json as_json(const loop_limits &limits)
{
    const auto one = [](const std::optional<double> &limit) {
        return limit ? nlohmann::json(*limit) : nlohmann::json();
    };
    return {{"reduced", one(limits.reduced)},
            {"full", one(limits.full)},
            {"looked_from", limits.looked_from},
            {"looked_to", limits.looked_to}};
}

nlohmann::json with_ranges(const loop_limits &limits)
{
    const auto all = [](const std::vector<stable_range> &ranges) {
        nlohmann::json list = nlohmann::json::array();
        for (const stable_range &range : ranges) {
            list.push_back({range.from, range.to});
        }
        return list;
    };
    nlohmann::json json = as_json(limits);
    json["reduced_stable"] = all(limits.reduced_ranges);
    json["full_stable"] = all(limits.full_ranges);
    return json;
}

std::string number_text(const char *format, double value)
{
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::string limit_text(const loop_limits &limits, const std::optional<double> &limit)
{
    if (!limit) {
        return number_text("> %.4g", limits.looked_to);
    }
    return *limit > 0.0 ? number_text("%.4g", *limit) : number_text("< %.4g", limits.looked_from);
}

/* Those beyond the limit that is told. */
std::string further_text(const loop_limits &limits, const std::vector<stable_range> &ranges)
{
    std::string text;
    for (const stable_range &range : ranges) {
        if (range.from > limits.looked_from) {
            text += (text.empty() ? "" : ", ") + number_text("%.4g to ", range.from) +
                    (range.to < limits.looked_to ? "" : "> ") + number_text("%.4g", range.to);
        }
    }
    return text;
}

void print_further(const char *model, const std::string &ranges)
{
    if (!ranges.empty()) {
        std::printf("  %-44s %s\n", ("  stable again, " + std::string(model) + ", ms").c_str(), ranges.c_str());
    }
}

/* What of a mode is the attitude control's, from a hundredth on. */
std::string held_text(const arm_mode &mode)
{
    if (mode.attitude_share < 0.01) {
        return "";
    }
    return "   held by the attitude control to" + number_text(" %.0f %%", 100.0 * mode.attitude_share);
}

/* What an arm's and a beam's reduction have in common. */
template <typename reduction_type>
void print_comparison(const char *full_title, const char *coupled_title, const reduction_type &found)
{
    const auto line = [](const char *what, const std::string &reduced, const std::string &full) {
        std::printf("  %-44s %12s %12s\n", what, reduced.c_str(), full.c_str());
    };
    line("", "reduced", full_title);
    const std::optional<swing> full = found.coupled_full;
    line(coupled_title, number_text("%.4f", found.coupled_reduced.frequency_Hz),
         full ? number_text("%.4f", full->frequency_Hz) : "none near");
    line("  damping ratio", number_text("%.5f", found.coupled_reduced.damping_ratio),
         full ? number_text("%.5f", full->damping_ratio) : "");
    line("in the loop: growth /s", number_text("%+.5f", found.loop_reduced.growth_per_s),
         number_text("%+.5f", found.loop_full.growth_per_s));
    line("  of a mode at Hz", number_text("%.4f", found.loop_reduced.frequency_Hz),
         number_text("%.4f", found.loop_full.frequency_Hz));
    line("object's stiffness may be, times its own",
         limit_text(found.object_stiffness, found.object_stiffness.reduced),
         limit_text(found.object_stiffness, found.object_stiffness.full));
    line("robot's dead time may be up to, ms", limit_text(found.dead_time_ms, found.dead_time_ms.reduced),
         limit_text(found.dead_time_ms, found.dead_time_ms.full));
    print_further("reduced", further_text(found.dead_time_ms, found.dead_time_ms.reduced_ranges));
    print_further(full_title, further_text(found.dead_time_ms, found.dead_time_ms.full_ranges));
}

} // namespace

std::vector<std::string> what_is_compared(const rig &rig)
{
    if (!rig.has_side_axes()) {
        return {};
    }
    return {"the axes show where the tool goes across; the reduced model is without them",
            "the object's stiffness is that along x alone; [axis.*] has its own along the others",
            "the dead times of all axes move by the same amount; told is that along x"};
}

std::string text_of(const Eigen::VectorXd &values)
{
    std::string text;
    for (const double value : values) {
        text.append(text.empty() ? "" : ", ").append(number_text("%.4g", value));
    }
    return text;
}

std::string conditions_text(const arm_config &arm, const reduction_choice &choice)
{
    std::string text = "along (";
    text.append(text_of(choice.direction))
        .append(choice.is_guided ? "), tool guided by a rail that no run has" : "), tool free across");
    return text.append(arm.base_is_free != 0 ? ", satellite free" : ", satellite held");
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
            {"object_limit", as_json(found.object_stiffness)},
            {"dead_time_limit_ms", with_ranges(found.dead_time_ms)}};
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
            {"arm_at_start", found.arm_at_start ? as_json(*found.arm_at_start) : nlohmann::json()},
            {"coupled", {{"reduced", as_json(found.coupled_reduced)}, {"full", as_json(found.coupled_full)}}},
            {"loop", {{"reduced", as_json(found.loop_reduced)}, {"full", as_json(found.loop_full)}}},
            {"object_limit", as_json(found.object_stiffness)},
            {"dead_time_limit_ms", with_ranges(found.dead_time_ms)}};
}

void print_reduction(const reduction &found)
{
    const arm_mode &r = found.reduced;
    std::printf("  reduced to one degree of freedom: M = %.6g kg, D = %.6g N s/m, K = %.6g N/m (%.4f Hz, damping "
                "ratio %.4f)\n",
                r.mass_kg, r.damping_N_s_per_m, r.stiffness_N_per_m, r.frequency_Hz, r.damping_ratio);
    std::printf("  modes along the direction\n    %10s %10s %10s %12s\n", "Hz", "damping", "share", "mass kg");
    for (const arm_mode &mode : found.modes) {
        std::printf("    %10.4f %10.4f %9.2f%% %12.5g%s\n", mode.frequency_Hz, mode.damping_ratio,
                    100.0 * mode.share, mode.mass_kg, held_text(mode).c_str());
    }
    print_comparison("full arm", "with the object, no dead time: Hz", found);
    if (!found.nearest) {
        std::printf("  %s\n", none_is_near(found.visible, found.coupled_reduced.frequency_Hz).c_str());
    }
}

void print_object(const rig &rig, const object_reduction &found)
{
    const beam_mode &first = found.modes.front();
    std::printf("the beam of %s, %d mode%s\n", rig.name.c_str(), static_cast<int>(found.modes.size()),
                found.modes.size() == 1 ? "" : "s");
    std::printf(
        "  reduced to one degree of freedom: m = %.6g kg, d = %.6g N s/m, k = %.6g N/m (%.4f Hz), %.2f %% of "
        "the compliance\n",
        first.mass_kg, first.damping_N_s_per_m, first.stiffness_N_per_m, first.frequency_Hz,
        100.0 * found.compliance_share);
    std::printf("  modes at the tip\n    %10s %12s %14s\n", "Hz", "mass kg", "stiffness N/m");
    for (const beam_mode &mode : found.modes) {
        std::printf("    %10.4f %12.5g %14.6g\n", mode.frequency_Hz, mode.mass_kg, mode.stiffness_N_per_m);
    }
    if (const auto &arm = found.arm_at_start) {
        std::printf(
            "  the manipulator is the arm at its start, reduced: M = %.6g kg, D = %.6g N s/m, K = %.6g N/m\n",
            arm->mass_kg, arm->damping_N_s_per_m, arm->stiffness_N_per_m);
    }
    print_comparison("all modes", "with the manipulator, no dead time: Hz", found);
    std::printf("  error of the first coupled frequency with one mode %+.3f %%\n",
                100.0 * (found.coupled_reduced.frequency_Hz / found.coupled_full.frequency_Hz - 1.0));
}

void print_sweep_head()
{
    std::printf("  reduced, then full arm\n  %9s %10s %9s %8s %23s %23s %21s\n", "rad", "mass kg", "Hz", "share",
                "with the object, Hz", "growth in the loop /s", "object's stiffness, x");
}

void print_sweep_row(double angle_rad, const reduction &found)
{
    const loop_limits &stiffness = found.object_stiffness;
    std::printf("  %9.3f %10.2f %9.4f %7.1f%% %11.4f %11s %11.5f %11.5f %10s %10s\n", angle_rad,
                found.reduced.mass_kg, found.reduced.frequency_Hz, 100.0 * found.reduced.share,
                found.coupled_reduced.frequency_Hz,
                found.coupled_full ? number_text("%.4f", found.coupled_full->frequency_Hz).c_str() : "none near",
                found.loop_reduced.growth_per_s, found.loop_full.growth_per_s,
                limit_text(stiffness, stiffness.reduced).c_str(), limit_text(stiffness, stiffness.full).c_str());
}

} // namespace berth
