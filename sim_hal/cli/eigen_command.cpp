#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../stability/lyapunov.h"
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

void print_spectra(const rig &steady, const char *loop_title)
{
    print_modes(loop_title, loop_spectrum(steady));
    print_modes("manipulator alone", manipulator_spectrum(steady));
    print_modes("manipulator and object coupled, without dead time", coupled_spectrum(steady));
}

nlohmann::json spectra_json(const rig &steady)
{
    nlohmann::json json = as_json(loop_spectrum(steady));
    json["rig"] = steady.name;
    json["manipulator"] = as_json(manipulator_spectrum(steady));
    json["coupled"] = as_json(coupled_spectrum(steady));
    return json;
}

int steady_eigen(const rig &rig, bool wants_json)
{
    if (wants_json) {
        print_json(spectra_json(rig));
        return 0;
    }
    const spectrum loop = loop_spectrum(rig);
    std::printf("%s: %s, spectral radius %.9f, growth %+.6f /s\n", rig.name.c_str(),
                loop.is_stable ? "stable" : "UNSTABLE", loop.spectral_radius, loop.growth_per_s);
    print_spectra(rig, "loop with dead time");
    return 0;
}

/* No eigenvalues, but an exponent; for comparison those of the loop without what makes it change. */
int varying_eigen(const rig &rig, const varying_arguments &arguments)
{
    const wake_histogram histogram = load_wake_histogram(rig);
    const struct rig steady = without_variation(rig);
    const spectrum loop = loop_spectrum(steady);
    const lyapunov_exponent exponent = exponent_of(rig, histogram, arguments.ticks);
    const std::vector<std::string> effects = what_varies(rig, histogram);
    const double low = exponent.growth_per_s - exponent.ci95_per_s;
    const double high = exponent.growth_per_s + exponent.ci95_per_s;
    if (arguments.json) {
        print_json({{"rig", rig.name},
                    {"eigenvalues", nullptr},
                    {"spectral_radius", nullptr},
                    {"growth_per_s", exponent.growth_per_s},
                    {"growth_ci95_per_s", exponent.ci95_per_s},
                    {"stable", low < 0.0 && high > 0.0 ? nlohmann::json() : nlohmann::json(high <= 0.0)},
                    {"ticks", exponent.ticks},
                    {"seed", rig.run.seed},
                    {"varies", effects},
                    {"without", spectra_json(steady)}});
        return 0;
    }
    std::printf("%s: %s, Lyapunov exponent %+.6f /s (+-%.1g) over %lld ticks, seed %lld\n", rig.name.c_str(),
                low < 0.0 && high > 0.0 ? "NOT DETERMINED"
                : high <= 0.0           ? "stable"
                                        : "UNSTABLE",
                exponent.growth_per_s, exponent.ci95_per_s, static_cast<long long>(exponent.ticks),
                static_cast<long long>(rig.run.seed));
    for (const std::string &effect : effects) {
        std::printf("  %s\n", effect.c_str());
    }
    std::printf("  without: %s, spectral radius %.9f, growth %+.6f /s\n", loop.is_stable ? "stable" : "UNSTABLE",
                loop.spectral_radius, loop.growth_per_s);
    print_spectra(steady, "loop with dead time, without that");
    return 0;
}

} // namespace

rig load_rig(const varying_arguments &arguments)
{
    std::vector<std::string> overrides = arguments.overrides;
    if (!arguments.jitter_file.empty()) {
        overrides.push_back("run.lateness_file=" + arguments.jitter_file);
    }
    if (arguments.seed >= 0) {
        overrides.push_back("run.seed=" + std::to_string(arguments.seed));
    }
    return load_rig(arguments.rig, overrides);
}

int eigen_command(const varying_arguments &arguments)
{
    const rig rig = load_rig(arguments);
    return is_time_varying(rig) ? varying_eigen(rig, arguments) : steady_eigen(rig, arguments.json);
}

} // namespace berth
