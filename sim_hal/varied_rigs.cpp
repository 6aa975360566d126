#include "varied_rigs.h"

#include <charconv>
#include <cmath>
#include <limits>

#include "../hal/rig/keys.h"
#include "../hal/rig/rig_file.h"
#include "loop_at_amplitude.h"
#include "schedule.h"
#include "stability/loop_timeline.h"

namespace berth
{

namespace
{

std::string exact_text(double value, key_type type)
{
    char text[40];
    const auto end = type == key_type::integer
                         ? std::to_chars(text, text + sizeof text, static_cast<std::int64_t>(value))
                         : std::to_chars(text, text + sizeof text, value);
    return {text, end.ptr};
}

/* Throws input_error in the words of `--set`. */
void put(rig &into, const rig_key &key, double value)
{
    const std::string text = exact_text(value, key.type);
    if (const auto error = set_value(into, key.path, text)) {
        throw input_error("--set " + std::string(key.path) + "=" + text, error->key, error->message);
    }
}

std::vector<const rig_key *> keys_called(const std::vector<std::string> &paths)
{
    std::vector<const rig_key *> found;
    for (const std::string &path : paths) {
        const rig_key *const key = find_key(path);
        if (key == nullptr) {
            throw input_error("vary", path,
                              "unknown key; the nearest known one is " + std::string(nearest_key(path)));
        }
        if (key->type != key_type::number && key->type != key_type::integer) {
            throw input_error("vary", path, "is no number");
        }
        found.push_back(key);
    }
    return found;
}

} // namespace

spectrum deciding_spectrum(const rig &of)
{
    const double amplitude_m = amplitude_of(of);
    const rig worst = has_schedule(of) ? worst_of_schedule(of, predictor_at(amplitude_m)).rig : of;
    if (is_time_varying(worst)) {
        throw input_error(of.name + ": the loop changes from tick to tick and has no eigenvalues: ask verdict()");
    }
    return loop_spectrum(linear_at(worst, amplitude_m));
}

bool is_settable(const rig &of)
{
    return of.firmware.arm.kind == ARM_NONE && of.object.kind != object_kind::beam && !of.has_side_axes();
}

varied_growth growth_of_varied(const rig &base, const std::vector<std::string> &keys, const double *values,
                               std::size_t rigs)
{
    const std::vector<const rig_key *> known = keys_called(keys);
    if (!is_settable(base)) {
        throw input_error(base.name + ": a rig with an arm, a beam or further axes is read anew for each change");
    }
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    varied_growth found{std::vector<double>(rigs, nan), std::vector<double>(rigs, nan),
                        std::vector<std::string>(rigs)};
    for (std::size_t i = 0; i < rigs; i++) {
        try {
            rig one = base;
            for (std::size_t j = 0; j < known.size(); j++) {
                put(one, *known[j], values[i * known.size() + j]);
            }
            if (const auto error = complete_and_check(one)) {
                throw input_error("--set", error->key, error->message);
            }
            const spectrum of_one = deciding_spectrum(one);
            found.growth_per_s[i] = of_one.growth_per_s;
            found.spectral_radius[i] = of_one.spectral_radius;
        } catch (const input_error &error) {
            found.refusal[i] = error.what();
        }
    }
    return found;
}

} // namespace berth
