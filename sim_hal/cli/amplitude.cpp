#include "amplitude.h"

#include <cmath>
#include <cstdio>

#include "../stability/arm_loop.h"
#include "../stability/spectrum.h"
#include "json_or_null.h"

namespace berth
{

namespace
{

nlohmann::json as_json(const equivalent_part &part)
{
    return {{"effect", part.what},
            {"gain", part.gain},
            {"lag_deg", part.lag_deg},
            {"stiffness_N_per_m", part.force.stiffness_N_per_m},
            {"damping_N_s_per_m", part.force.damping_N_s_per_m}};
}

} // namespace

double chosen_amplitude_m(const rig_arguments &arguments, const rig &rig)
{
    if (arguments.amplitude_m && !(*arguments.amplitude_m >= 0.0 && std::isfinite(*arguments.amplitude_m))) {
        throw input_error("--amplitude: must be an amplitude of the motion in m, or 0 for small motions");
    }
    return amplitude_of(rig, arguments.amplitude_m);
}

const char *guess_text(bool has_settled)
{
    return has_settled ? "" : " (A GUESS: the describing function did not settle)";
}

nlohmann::json stable_json(double growth_per_s, double spectral_radius, bool is_free)
{
    constexpr double drift_rounding = 1e-6; /* moves z = 1 by this much where it is a double eigenvalue */
    if (is_free && spectral_radius < 1.0 + drift_rounding) {
        return nullptr;
    }
    return or_null(is_stable({growth_per_s, {}}));
}

nlohmann::json unless_guess(bool has_settled, const nlohmann::json &stable)
{
    return has_settled ? stable : nlohmann::json();
}

nlohmann::json describing_function_json(const rig &rig, double amplitude_m)
{
    if (!(amplitude_m > 0.0)) {
        return nullptr;
    }
    const equivalent_loop found = equivalent_finder(amplitude_m).find(rig);
    nlohmann::json json = {{"amplitude_m", amplitude_m},         {"frequency_Hz", found.frequency_Hz},
                           {"growth_per_s", found.growth_per_s}, {"settled", found.has_settled},
                           {"effects", nlohmann::json::array()}, {"limit_cycles", nlohmann::json::array()}};
    for (const equivalent_part &part : found.parts) {
        json["effects"].push_back(as_json(part));
    }
    for (const limit_cycle &cycle : limit_cycles(rig, amplitude_m)) {
        json["limit_cycles"].push_back({{"amplitude_m", cycle.amplitude_m},
                                        {"frequency_Hz", cycle.frequency_Hz},
                                        {"attracts", cycle.attracts}});
    }
    return json;
}

void print_describing_function(const nlohmann::json &told)
{
    if (told.is_null()) {
        return;
    }
    std::printf("  describing function at %g m and %.4f Hz%s\n", told["amplitude_m"].get<double>(),
                told["frequency_Hz"].get<double>(),
                told["settled"].get<bool>() ? "" : "; NOT SETTLED: no frequency agrees with its own phases");
    for (const nlohmann::json &part : told["effects"]) {
        std::printf("    %s: ", part["effect"].get<std::string>().c_str());
        if (part["stiffness_N_per_m"] == 0.0 && part["damping_N_s_per_m"] == 0.0) {
            std::printf("gain %.4f, %.2f degrees late\n", part["gain"].get<double>(), part["lag_deg"].get<double>());
        } else {
            std::printf("stiffness %+.6g N/m, damping %+.6g N s/m\n", part["stiffness_N_per_m"].get<double>(),
                        part["damping_N_s_per_m"].get<double>());
        }
    }
    for (const nlohmann::json &cycle : told["limit_cycles"]) {
        std::printf("  limit cycle of %.4g m at %.4f Hz: %s\n", cycle["amplitude_m"].get<double>(),
                    cycle["frequency_Hz"].get<double>(),
                    cycle["attracts"].get<bool>() ? "smaller motion grows to it, larger one decays to it"
                                                  : "smaller motion decays, larger one grows");
    }
}

} // namespace berth
