#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../stability/lyapunov.h"
#include "../stability/spectrum.h"
#include "amplitude.h"
#include "commands.h"
#include "robot_choice.h"

namespace berth
{

namespace
{

nlohmann::json as_json(const spectrum &spectrum, bool is_free)
{
    nlohmann::json eigenvalues = nlohmann::json::array();
    for (const mode &mode : spectrum.modes) {
        eigenvalues.push_back({mode.z.real(), mode.z.imag()});
    }
    return {{"eigenvalues", eigenvalues},
            {"spectral_radius", spectrum.spectral_radius},
            {"growth_per_s", spectrum.growth_per_s},
            {"stable", stable_json(spectrum.spectral_radius, is_free)}};
}

void print_modes(const char *title, const spectrum &spectrum)
{
    std::printf("%s\n  %-26s %12s %12s %12s %10s\n", title, "z", "|z|", "growth /s", "Hz", "damping");
    for (const mode &mode : spectrum.modes) {
        if (mode.z.imag() < 0.0) {
            continue; /* the other one of the pair stands for both */
        }
        const char *const sign = mode.z.imag() > 0.0 ? "+-" : "  ";
        std::printf("  %+.8f %s %.8fi  %12.9f %12.6f %12.6f %10.6f\n", mode.z.real(), sign, mode.z.imag(),
                    std::abs(mode.z), mode.growth_per_s, mode.frequency_Hz, mode.damping_ratio);
    }
}

nlohmann::json as_json(const settled_rig &at)
{
    nlohmann::json json = as_json(loop_spectrum(at.linear), drifts_freely(at.linear));
    json["stable"] = unless_guess(at.has_settled, json["stable"]);
    return json;
}

nlohmann::json spectra_json(const rig &steady, double amplitude_m)
{
    nlohmann::json json = as_json(settle_at(steady, amplitude_m));
    json["rig"] = steady.name;
    json["left_out"] = left_out(steady, amplitude_m);
    json["describing_function"] = describing_function_json(steady, amplitude_m);
    const bool is_arm = steady.firmware.arm.kind != ARM_NONE;
    json["manipulator"] =
        as_json(manipulator_spectrum(steady), !is_arm && steady.firmware.manipulator.stiffness_N_per_m == 0.0);
    json["coupled"] = as_json(coupled_spectrum(steady), drifts_freely(steady));
    return json;
}

void print_spectra(const rig &steady, const spectrum &loop, const char *loop_title)
{
    print_modes(loop_title, loop);
    const bool is_arm = steady.firmware.arm.kind != ARM_NONE;
    print_modes(is_arm ? "arm alone" : "manipulator alone", manipulator_spectrum(steady));
    print_modes(is_arm ? "arm and object coupled, without dead time"
                       : "manipulator and object coupled, without dead time",
                coupled_spectrum(steady));
}

/* `title` goes before it. Returns the eigenvalues, which take long to find where the dead time is long. */
spectrum print_verdict(const char *title, const settled_rig &at)
{
    spectrum loop = loop_spectrum(at.linear);
    const nlohmann::json stable = stable_json(loop.spectral_radius, drifts_freely(at.linear));
    std::printf("%s: %s, spectral radius %.9f, growth %+.6f /s%s\n", title,
                stable.is_null() ? "NEITHER STABLE NOR UNSTABLE (no spring holds manipulator or object: z = 1)"
                : stable == true ? "stable"
                                 : "UNSTABLE",
                loop.spectral_radius, loop.growth_per_s, guess_text(at.has_settled));
    return loop;
}

/* Null where the interval of the exponent holds 0. */
nlohmann::json exponent_stable_json(const lyapunov_exponent &exponent)
{
    if (std::abs(exponent.growth_per_s) < exponent.ci95_per_s) {
        return nullptr;
    }
    return exponent.growth_per_s <= 0.0;
}

nlohmann::json as_json(const lyapunov_exponent &exponent, bool has_settled)
{
    return {{"eigenvalues", nullptr},
            {"spectral_radius", nullptr},
            {"growth_per_s", exponent.growth_per_s},
            {"growth_ci95_per_s", exponent.ci95_per_s},
            {"stable", unless_guess(has_settled, exponent_stable_json(exponent))},
            {"ticks", exponent.ticks}};
}

void print_verdict(const lyapunov_exponent &exponent, std::int64_t seed, bool has_settled)
{
    const nlohmann::json stable = exponent_stable_json(exponent);
    std::printf("%s, Lyapunov exponent %+.6f /s (+-%.1g) over %lld ticks, seed %lld%s\n",
                stable.is_null() ? "NOT DETERMINED"
                : stable == true ? "stable"
                                 : "UNSTABLE",
                exponent.growth_per_s, exponent.ci95_per_s, static_cast<long long>(exponent.ticks),
                static_cast<long long>(seed), guess_text(has_settled));
}

void print_robot(const chosen_rig &chosen)
{
    if (chosen.robot) {
        std::printf("  robot %s\n", robot_sentence(robot_as_json(chosen)).c_str());
    }
}

int steady_eigen(const chosen_rig &chosen, double amplitude_m, bool wants_json)
{
    const rig &rig = chosen.rig;
    std::optional<settled_rig> lower_end;
    if (chosen.dead_time_band) {
        lower_end = settle_at(chosen.at_lower_end(), amplitude_m);
    }
    if (wants_json) {
        nlohmann::json json = spectra_json(rig, amplitude_m);
        json["robot"] = robot_as_json(chosen);
        json["lower_end"] = nullptr;
        if (lower_end) {
            json["lower_end"] = as_json(*lower_end);
            json["lower_end"]["dead_time_ms"] = chosen.dead_time_band->from;
        }
        print_json(json);
        return 0;
    }
    const spectrum loop = print_verdict(rig.name.c_str(), settle_at(rig, amplitude_m));
    print_robot(chosen);
    print_describing_function(describing_function_json(rig, amplitude_m));
    if (lower_end) {
        char title[60];
        std::snprintf(title, sizeof title, "  dead time %g ms, the lower end", chosen.dead_time_band->from);
        print_verdict(title, *lower_end);
    }
    print_spectra(rig, loop, "loop with dead time");
    return 0;
}

/* No eigenvalues, but an exponent; for comparison those of the loop without what makes it change. */
int varying_eigen(const chosen_rig &chosen, double amplitude_m, std::int64_t ticks, bool wants_json)
{
    const rig &rig = chosen.rig;
    const wake_histogram histogram = load_wake_histogram(rig);
    const struct rig steady = without_variation(rig);
    const settled_rig own = settle_at(rig, amplitude_m);
    const lyapunov_exponent exponent = exponent_of(own.linear, histogram, ticks);
    std::optional<settled_rig> low;
    std::optional<lyapunov_exponent> lower_end;
    if (chosen.dead_time_band) {
        low = settle_at(chosen.at_lower_end(), amplitude_m);
        lower_end = exponent_of(low->linear, histogram, ticks);
    }
    const std::vector<std::string> effects = what_varies(rig, histogram);
    if (wants_json) {
        nlohmann::json json = as_json(exponent, own.has_settled);
        json.update({{"rig", rig.name},
                     {"left_out", left_out(rig, amplitude_m)},
                     {"describing_function", describing_function_json(rig, amplitude_m)},
                     {"robot", robot_as_json(chosen)},
                     {"lower_end", nullptr},
                     {"seed", rig.run.seed},
                     {"varies", effects},
                     {"without", spectra_json(steady, amplitude_m)}});
        if (lower_end) {
            json["lower_end"] = as_json(*lower_end, low->has_settled);
            json["lower_end"]["dead_time_ms"] = chosen.dead_time_band->from;
        }
        print_json(json);
        return 0;
    }
    std::printf("%s: ", rig.name.c_str());
    print_verdict(exponent, rig.run.seed, own.has_settled);
    print_robot(chosen);
    print_describing_function(describing_function_json(rig, amplitude_m));
    if (lower_end) {
        std::printf("  dead time %g ms, the lower end: ", chosen.dead_time_band->from);
        print_verdict(*lower_end, rig.run.seed, low->has_settled);
    }
    for (const std::string &effect : effects) {
        std::printf("  %s\n", effect.c_str());
    }
    const spectrum loop = print_verdict("  without", settle_at(steady, amplitude_m));
    print_spectra(steady, loop, "loop with dead time, without that");
    return 0;
}

} // namespace

int eigen_command(const varying_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    const double amplitude_m = chosen_amplitude_m(arguments, chosen.rig);
    tell_left_out(chosen.rig, amplitude_m);
    return is_time_varying(chosen.rig) ? varying_eigen(chosen, amplitude_m, arguments.ticks, arguments.json)
                                       : steady_eigen(chosen, amplitude_m, arguments.json);
}

} // namespace berth
