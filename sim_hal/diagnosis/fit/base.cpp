#include "base.h"

#include <algorithm>
#include <cmath>

#include "../../effects/effect.h"

namespace berth
{

namespace
{

/* Share of a key's value that a rig file which says nothing lets it be off. */
constexpr double usual_tolerance = 0.05;

constexpr block all_blocks[] = {block::manipulator, block::robot, block::force};

std::vector<std::string_view> keys_of_base_model(block block, const rig &rig)
{
    std::vector<std::string_view> keys;
    const auto add_if = [&](bool condition, std::string_view key) {
        if (condition) {
            keys.push_back(key);
        }
    };
    switch (block) {
    case block::manipulator:
        keys = {"manipulator.mass_kg"};
        add_if(rig.firmware.manipulator.damping_N_s_per_m > 0.0, "manipulator.damping_N_s_per_m");
        add_if(rig.firmware.manipulator.stiffness_N_per_m > 0.0, "manipulator.stiffness_N_per_m");
        break;
    case block::robot:
        keys = {"robot.dead_time_ms"};
        add_if(rig.has_transfer_behaviour(), "robot.transfer_frequency_Hz");
        add_if(rig.has_transfer_behaviour(), "robot.transfer_damping_ratio");
        break;
    case block::force:
        keys = {"object.mass_kg"};
        add_if(rig.object.damping_N_s_per_m > 0.0, "object.damping_N_s_per_m");
        add_if(rig.object.stiffness_N_per_m > 0.0, "object.stiffness_N_per_m");
        add_if(rig.sensor.low_pass_order > 0, "sensor.low_pass_frequency_Hz");
        add_if(rig.sensor.low_pass_order == 2, "sensor.low_pass_damping_ratio");
        keys.push_back("sensor.delay_ms");
        keys.push_back("sensor.stiffness_N_per_m");
        add_if(rig.sensor.damping_ratio > 0.0, "sensor.damping_ratio");
        break;
    }
    return keys;
}

bool is_of(const effect &effect, block block)
{
    switch (block) {
    case block::manipulator:
        return effect.block() == "manipulator";
    case block::robot:
        return effect.block() == "robot";
    case block::force:
        return effect.block() == "object" || effect.block() == "sensor";
    }
    return false;
}

bool is_sized(double value)
{
    return value != 0.0 && std::abs(value) < unlimited;
}

/* The first parameter is the size: without it the others are of nothing. */
bool is_in(const rig &rig, const effect &effect)
{
    return is_active(effect, rig) || is_sized(value_of(rig, effect.parameters[0].key));
}

/* Of effects that the rig has, where slopes of the error mean something. */
std::vector<std::string_view> keys_of_effects(block block, const rig &rig)
{
    std::vector<std::string_view> keys;
    for (const effect &known : effect_library()) {
        if (!is_of(known, block) || known.is_rough || known.is_of_single_samples || !is_in(rig, known)) {
            continue;
        }
        for (const effect_parameter &parameter : known.parameters) {
            if (std::find(keys.begin(), keys.end(), parameter.key) == keys.end()) {
                keys.push_back(parameter.key);
            }
        }
    }
    return keys;
}

void add(std::vector<free_parameter> &parameters, const rig &given, std::string_view path, double tolerance)
{
    const double value = value_of(given, path);
    const double way = tolerance * std::abs(value);
    if (tolerance > 0.0 && is_sized(value)) {
        parameters.push_back({find_key(path), value - way, value + way, value, way});
    }
}

bool has(const std::vector<std::string_view> &keys, std::string_view key)
{
    return std::find(keys.begin(), keys.end(), key) != keys.end();
}

bool is_of_base_model(const rig &given, std::string_view key)
{
    return std::any_of(std::begin(all_blocks), std::end(all_blocks),
                       [&](block block) { return has(keys_of_base_model(block, given), key); });
}

} // namespace

std::vector<free_parameter> base_parameters(block block, const rig &given)
{
    std::vector<free_parameter> parameters;
    const std::vector<std::string_view> of_model = keys_of_base_model(block, given);
    for (const std::string_view path : of_model) {
        add(parameters, given, path, given.tolerance_of(path).value_or(usual_tolerance));
    }
    for (const std::string_view path : keys_of_effects(block, given)) {
        if (!has(of_model, path)) {
            add(parameters, given, path, given.tolerance_of(path).value_or(0.0));
        }
    }
    return parameters;
}

void state_tolerances_of_effects(rig &given)
{
    for (const effect &known : effect_library()) {
        for (const effect_parameter &parameter : known.parameters) {
            if (is_in(given, known) && !is_of_base_model(given, parameter.key) &&
                !given.tolerance_of(parameter.key)) {
                given.tolerances.push_back({std::string(parameter.key), usual_tolerance});
            }
        }
    }
}

std::vector<std::string_view> tolerances_without_use(const rig &given)
{
    rig stated = given;
    stated.tolerances.clear();
    state_tolerances_of_effects(stated);
    std::vector<std::string_view> unused;
    for (const tolerance &one : given.tolerances) {
        if (one.share > 0.0 && !stated.tolerance_of(one.key) && !is_of_base_model(given, one.key)) {
            unused.push_back(one.key);
        }
    }
    return unused;
}

} // namespace berth
