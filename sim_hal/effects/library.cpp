#include <algorithm>

#include "active.h"
#include "effects.h"

namespace berth
{

const std::vector<effect> &effect_library()
{
#define MADE_EFFECT(name) name(),
    static const std::vector<effect> library = {EFFECT_LIBRARY(MADE_EFFECT)};
#undef MADE_EFFECT
    return library;
}

const effect *find_effect(std::string_view name)
{
    for (const effect &known : effect_library()) {
        if (known.name == name) {
            return &known;
        }
    }
    return nullptr;
}

const std::vector<effect_key> &effect_keys()
{
    static const std::vector<effect_key> keys = [] {
        std::vector<effect_key> found;
        for (const effect &effect : effect_library()) {
            std::string_view size; /* the first key that it brought along */
            for (const effect_parameter &parameter : effect.parameters) {
                if (!parameter.meaning.empty()) {
                    found.push_back({parameter.key, parameter.low < 0.0 ? -unlimited : 0.0, parameter.meaning,
                                     parameter.low > 0.0 ? size : std::string_view()});
                    size = size.empty() ? parameter.key : size;
                }
            }
        }
        return found;
    }();
    return keys;
}

namespace
{

/* Looked up once: this is asked for in every replay. */
struct own_key {
    const effect *of;
    const rig_key *size; /* the first key that it brought along; nullptr: it has none */
};

const std::vector<own_key> &own_keys()
{
    static const std::vector<own_key> found = [] {
        std::vector<own_key> all;
        for (const effect &known : effect_library()) {
            const auto own =
                std::find_if(known.parameters.begin(), known.parameters.end(),
                             [](const effect_parameter &parameter) { return !parameter.meaning.empty(); });
            all.push_back({&known, own == known.parameters.end() ? nullptr : find_key(own->key)});
        }
        return all;
    }();
    return found;
}

bool has_any_value(const rig &rig)
{
    return std::any_of(rig.effect_values.begin(), rig.effect_values.end(),
                       [](double value) { return value != 0.0; });
}

} // namespace

bool is_active(const effect &effect, const rig &rig)
{
    const auto &keys = own_keys();
    const auto found = std::find_if(keys.begin(), keys.end(), [&](const own_key &key) { return key.of == &effect; });
    return found != keys.end() && found->size != nullptr && rig.effect_values[found->size->effect_value] != 0.0;
}

double value_of(const rig &rig, std::string_view key)
{
    return *static_cast<double *>(find_key(key)->member(const_cast<berth::rig &>(rig)));
}

bool is_hardware_effect(const effect &effect)
{
    const bool is_in_hardware = effect.on_motion != nullptr || effect.on_force != nullptr ||
                                (effect.on_body != nullptr && effect.block() == "object") ||
                                effect.name == "object.loss_of_contact" || effect.name == "object.impact_damping";
    return is_in_hardware && effect.when_small != small_motion::in_the_equations;
}

bool has_hardware_effects(const rig &rig)
{
    const auto &library = effect_library();
    return has_any_value(rig) &&
           (saturates_in_lag(rig) || std::any_of(library.begin(), library.end(), [&](const effect &known) {
                return is_hardware_effect(known) && is_active(known, rig);
            }));
}

bool saturates_in_lag(const rig &rig)
{
    return rig.robot.velocity_limit_m_per_s != unlimited && value_of_effect(rig, "robot.lag_ms") > 0.0;
}

bool limits_reference(const rig &rig)
{
    return rig.robot.velocity_limit_m_per_s != unlimited && !saturates_in_lag(rig) &&
           rig.robot.acceleration_limit_m_per_s2 == unlimited;
}

bool is_beyond_small_motion(const effect &effect)
{
    return effect.when_small != small_motion::no_influence && effect.when_small != small_motion::in_the_equations;
}

bool is_beyond_free_swing(const effect &effect)
{
    return is_beyond_small_motion(effect) ||
           (effect.block() == "object" && effect.when_small == small_motion::in_the_equations);
}

namespace
{

/* Appended to `keys`, with commas between. */
void add_keys(std::string &keys, const effect &of, const rig &rig)
{
    for (const effect_parameter &parameter : of.parameters) {
        if (!parameter.meaning.empty() && value_of(rig, parameter.key) != 0.0) {
            keys.append(keys.empty() ? "" : ", ").append(parameter.key);
        }
    }
}

} // namespace

std::string effect_keys_of(const rig &rig, bool (*is_asked_for)(const effect &))
{
    std::string keys;
    for (const effect &known : effect_library()) {
        if (is_asked_for(known) && is_active(known, rig)) {
            add_keys(keys, known, rig);
        }
    }
    return keys;
}

std::vector<std::string> left_out_of_reduction(const rig &rig)
{
    std::vector<std::string> lines;
    for (const effect &known : effect_library()) {
        if (!is_beyond_free_swing(known) || !is_active(known, rig)) {
            continue;
        }
        std::string line;
        add_keys(line, known, rig);
        line += known.when_small == small_motion::drifts ? ": changes for as long as it runs: taken as at the start"
                : is_beyond_small_motion(known)
                    ? ": a reduction is of small motions and leaves it out"
                    : ": is in the loop only; the swing with the object alone leaves it out";
        lines.push_back(std::move(line));
    }
    return lines;
}

std::string effect_names(const rig &rig, bool (*is_asked_for)(const effect &))
{
    std::string names;
    for (const effect &known : effect_library()) {
        if (is_asked_for(known) && is_active(known, rig)) {
            names += (names.empty() ? "" : ", ") + std::string(known.name);
        }
    }
    return names;
}

double gain_when_small(const rig &rig)
{
    if (!has_any_value(rig)) {
        return 1.0;
    }
    return (1.0 + value_of(rig, "robot.gain_error")) * (1.0 + value_of(rig, "sensor.gain_error"));
}

std::vector<std::string> left_out_when_small(const rig &rig)
{
    std::vector<std::string> lines;
    for (const effect &known : effect_library()) {
        if (known.when_small == small_motion::depends_on_size && is_active(known, rig)) {
            lines.push_back(std::string(known.name) +
                            " has no linearisation: growth depends on the amplitude; left out for small motions");
        }
    }
    for (std::string &line : taken_as_at_the_start(rig)) {
        lines.push_back(std::move(line));
    }
    return lines;
}

std::vector<std::string> taken_as_at_the_start(const rig &rig)
{
    std::vector<std::string> lines;
    for (const effect &known : effect_library()) {
        if (known.when_small == small_motion::drifts && is_active(known, rig)) {
            lines.push_back(std::string(known.name) +
                            " changes the loop for as long as it runs: taken as it is at the start; run it");
        }
    }
    return lines;
}

rig without_effects_on_signals(const rig &original)
{
    rig made = original;
    made.effect_values.fill(0.0);
    for (const std::string_view key : {"robot.lost_command_probability", "loop.lost_sample_probability"}) {
        set_number(made, key, value_of(original, key));
    }
    return made;
}

double value_of_effect(const rig &rig, std::string_view key)
{
    if (!has_any_value(rig)) {
        return 0.0; /* the usual case, without a search for the key */
    }
    return value_of(rig, key);
}

void set_number(rig &rig, std::string_view key, double value)
{
    *static_cast<double *>(find_key(key)->member(rig)) = value;
}

} // namespace berth
