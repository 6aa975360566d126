#include "beam.h"

#include <cmath>
#include <cstdio>

#include "../../firmware/pi.h"
#include "rig_file.h"

namespace berth
{

namespace
{

struct bounds {
    const char *key;
    const char *meaning;
    double value;
    double low;
    double high;
};

std::string from_to(const bounds &of)
{
    char text[160];
    std::snprintf(text, sizeof text, "must be from %g to %g (is %g)", of.low, of.high, of.value);
    return text;
}

std::optional<rig_error> check_shape(const cantilever &beam)
{
    const bounds all[] = {
        {"object.beam_length_m", "root to grip", beam.length_m, 1e-3, 1e4},
        {"object.beam_mass_kg_per_m", "mass a length", beam.mass_kg_per_m, 1e-6, 1e6},
        {"object.beam_stiffness_N_m2", "E I", beam.bending_stiffness_N_m2, 1e-6, 1e15},
    };
    for (const bounds &one : all) {
        if (one.value == 0.0) {
            return rig_error{one.key,
                             std::string("is missing: object.kind = \"beam\" needs it (") + one.meaning + ")"};
        }
        if (!(one.value >= one.low && one.value <= one.high)) {
            return rig_error{one.key, from_to(one)};
        }
    }
    const double softest_N_m_per_rad = softest_root * beam.bending_stiffness_N_m2 / beam.length_m;
    if (beam.root_N_m_per_rad < softest_N_m_per_rad) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "is next to no spring for this beam (is %g): must be %g or more, or inf for a clamped root",
                      beam.root_N_m_per_rad, softest_N_m_per_rad);
        return rig_error{"object.beam_root_stiffness_N_m_per_rad", text};
    }
    return {};
}

/* As the object's own mass and stiffness are checked. */
std::optional<rig_error> check_mode(const beam_mode &mode, std::size_t number)
{
    const bounds all[] = {
        {"object.beam_mass_kg_per_m", "kg", mode.mass_kg, 1e-6, 1e9},
        {"object.beam_stiffness_N_m2", "N/m", mode.stiffness_N_per_m, 0.0, 1e13},
    };
    for (const bounds &one : all) {
        if (!(one.value >= one.low && one.value <= one.high)) {
            char text[200];
            std::snprintf(text, sizeof text, "gives mode %d %g %s at the tip: must be from %g to %g",
                          static_cast<int>(number), one.value, one.meaning, one.low, one.high);
            return rig_error{one.key, text};
        }
    }
    return {};
}

} // namespace

bool belongs_to_beam(std::string_view path)
{
    return path == "object.modes" || path.substr(0, 12) == "object.beam_";
}

bool follows_from_beam(std::string_view path)
{
    return path == "object.mass_kg" || path == "object.stiffness_N_per_m" || path == "object.damping_N_s_per_m";
}

std::optional<rig_error> complete_beam(rig &rig)
{
    object_rig &object = rig.object;
    if (object.kind != object_kind::beam ||
        (object.beam == object.followed_beam && object.modes == object.followed_modes)) {
        return {};
    }
    if (object.modes < 1 || object.modes > beam_modes_max) {
        return rig_error{"object.modes", "must be from 1 to " + std::to_string(beam_modes_max) + " (is " +
                                             std::to_string(object.modes) + ")"};
    }
    if (auto error = check_shape(object.beam)) {
        return error;
    }
    const std::vector<beam_mode> modes = modes_of(object.beam, static_cast<int>(object.modes));
    for (std::size_t i = 0; i < modes.size(); i++) {
        if (auto error = check_mode(modes[i], i + 1)) {
            return error;
        }
    }
    const beam_mode &first = modes.front();
    object.mass_kg = first.mass_kg;
    object.damping_N_s_per_m = first.damping_N_s_per_m;
    object.stiffness_N_per_m = first.stiffness_N_per_m;
    for (std::size_t i = 1; i < modes.size(); i++) {
        const beam_mode &mode = modes[i];
        const double mass = mode.mass_kg / first.mass_kg;
        /* The same damping ratio, whatever it is: d = 2 zeta sqrt(k m). */
        const double stiffness = mode.stiffness_N_per_m / first.stiffness_N_per_m;
        object.further_modes[i - 1] = {mass, std::sqrt(mass * stiffness), stiffness};
    }
    object.further_mode_count = object.modes - 1;
    object.followed_beam = object.beam;
    object.followed_modes = object.modes;
    return {};
}

void refuse_beam(const rig &rig)
{
    if (rig.object.further_mode_count > 0) {
        throw input_error(rig.name + ": object.modes: this reckons with an object of one degree of freedom; run, "
                                     "eigen, limits, map and reduce look at all modes of a beam. Look at its "
                                     "reduction, --set object.modes=1");
    }
}

beam_mode object_mode(const object_rig &object, std::int64_t i)
{
    mode_shares shares{1.0, 1.0, 1.0};
    if (i > 0) {
        shares = object.further_modes[static_cast<std::size_t>(i - 1)];
    }
    beam_mode mode{};
    mode.mass_kg = shares.mass * object.mass_kg;
    mode.damping_N_s_per_m = shares.damping * object.damping_N_s_per_m;
    mode.stiffness_N_per_m = shares.stiffness * object.stiffness_N_per_m;
    mode.frequency_Hz = std::sqrt(mode.stiffness_N_per_m / mode.mass_kg) / two_pi;
    return mode;
}

std::vector<beam_mode> object_modes(const object_rig &object)
{
    std::vector<beam_mode> modes;
    for (std::int64_t i = 0; i <= object.further_mode_count; i++) {
        modes.push_back(object_mode(object, i));
    }
    return modes;
}

} // namespace berth
