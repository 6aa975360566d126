#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../stability/spectrum.h"
#include "commands.h"

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

} // namespace

int eigen_command(const rig_arguments &arguments)
{
    const rig rig = load_rig(arguments.rig, arguments.overrides);
    const spectrum loop = loop_spectrum(rig);
    const spectrum manipulator = manipulator_spectrum(rig);
    const spectrum coupled = coupled_spectrum(rig);
    if (arguments.json) {
        nlohmann::json json = as_json(loop);
        json["rig"] = rig.name;
        json["manipulator"] = as_json(manipulator);
        json["coupled"] = as_json(coupled);
        std::printf("%s\n", json.dump().c_str());
        return 0;
    }
    std::printf("%s: %s, spectral radius %.9f, growth %+.6f /s\n", rig.name.c_str(),
                loop.is_stable ? "stable" : "UNSTABLE", loop.spectral_radius, loop.growth_per_s);
    print_modes("loop with dead time", loop);
    print_modes("manipulator alone", manipulator);
    print_modes("manipulator and object coupled, without dead time", coupled);
    return 0;
}

} // namespace berth
