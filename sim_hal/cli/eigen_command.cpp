#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../stability/spectrum.h"
#include "commands.h"
#include "robot_choice.h"

namespace berth
{

namespace
{

nlohmann::json as_json(const spectrum &spectrum)
{
    nlohmann::json eigenvalues = nlohmann::json::array();
    for (const mode &mode : spectrum.modes) {
        eigenvalues.push_back({mode.z.real(), mode.z.imag()});
    }
    return {{"eigenvalues", eigenvalues},
            {"spectral_radius", spectrum.spectral_radius},
            {"growth_per_s", spectrum.growth_per_s},
            {"stable", spectrum.is_stable}};
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

nlohmann::json told_as_json(const chosen_rig &chosen, const spectrum &loop, const std::optional<spectrum> &lower_end)
{
    nlohmann::json json = as_json(loop);
    json["rig"] = chosen.rig.name;
    json["manipulator"] = as_json(manipulator_spectrum(chosen.rig));
    json["coupled"] = as_json(coupled_spectrum(chosen.rig));
    json["robot"] = robot_as_json(chosen);
    json["lower_end"] = nullptr;
    if (lower_end) {
        json["lower_end"] = as_json(*lower_end);
        json["lower_end"]["dead_time_ms"] = chosen.dead_time_band->from;
    }
    return json;
}

void print_verdict(const spectrum &loop)
{
    std::printf("%s, spectral radius %.9f, growth %+.6f /s\n", loop.is_stable ? "stable" : "UNSTABLE",
                loop.spectral_radius, loop.growth_per_s);
}

} // namespace

int eigen_command(const rig_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    const rig &rig = chosen.rig;
    const spectrum loop = loop_spectrum(rig);
    std::optional<spectrum> lower_end;
    if (chosen.dead_time_band) {
        lower_end = loop_spectrum(chosen.at_lower_end());
    }
    const nlohmann::json json = told_as_json(chosen, loop, lower_end);
    if (arguments.json) {
        print_json(json);
        return 0;
    }
    std::printf("%s: ", rig.name.c_str());
    print_verdict(loop);
    if (chosen.robot) {
        std::printf("  robot %s\n", robot_sentence(json["robot"]).c_str());
    }
    if (lower_end) {
        std::printf("  dead time %g ms, the lower end: ", chosen.dead_time_band->from);
        print_verdict(*lower_end);
    }
    print_modes("loop with dead time", loop);
    print_modes("manipulator alone", manipulator_spectrum(rig));
    print_modes("manipulator and object coupled, without dead time", coupled_spectrum(rig));
    return 0;
}

} // namespace berth
