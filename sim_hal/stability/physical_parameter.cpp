#include "physical_parameter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>

#include "../../hal/rig/axes.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/effect.h"

namespace berth
{

namespace
{

struct physical_parameter {
    std::string_view key;
    parameter_scale kind;
};

constexpr physical_parameter parameters[] = {
    {"manipulator.mass_kg", parameter_scale::mass},
    {"manipulator.stiffness_N_per_m", parameter_scale::stiffness},
    {"manipulator.damping_N_s_per_m", parameter_scale::damping},
    {"object.mass_kg", parameter_scale::mass},
    {"object.stiffness_N_per_m", parameter_scale::stiffness},
    {"object.damping_N_s_per_m", parameter_scale::damping},
    {"robot.dead_time_ms", parameter_scale::delay},
    {"robot.transfer_frequency_Hz", parameter_scale::frequency},
    {"robot.transfer_damping_ratio", parameter_scale::ratio},
    {"robot.lag_ms", parameter_scale::delay},
    {"sensor.stiffness_N_per_m", parameter_scale::stiffness},
    {"sensor.damping_ratio", parameter_scale::ratio},
    {"sensor.low_pass_frequency_Hz", parameter_scale::frequency},
    {"sensor.low_pass_damping_ratio", parameter_scale::ratio},
    {"sensor.delay_ms", parameter_scale::delay},
    {"sensor.lag_ms", parameter_scale::delay},
    {"object.second_mass_kg", parameter_scale::mass},
    {"object.second_frequency_Hz", parameter_scale::frequency},
    {"object.second_damping_ratio", parameter_scale::ratio},
    {"object.relaxation_stiffness_N_per_m", parameter_scale::stiffness},
    {"object.relaxation_time_ms", parameter_scale::delay},
    {"sensor.tool_mass_kg", parameter_scale::mass},
};

} // namespace

parameter_scale scale_of(std::string_view key)
{
    const auto found = std::find_if(std::begin(parameters), std::end(parameters),
                                    [&](const physical_parameter &p) { return p.key == key; });
    if (found == std::end(parameters)) {
        throw input_error(std::string(key) + ": is no physical parameter with a limit");
    }
    return found->kind;
}

bool may_be_raised(std::string_view key)
{
    return scale_of(key) != parameter_scale::delay;
}

std::vector<std::string_view> physical_parameters(const rig &rig)
{
    std::vector<std::string_view> keys;
    for (const physical_parameter &parameter : parameters) {
        const std::string_view key = parameter.key;
        const bool is_absent =
            (key.find("robot.transfer") == 0 && !rig.has_transfer_behaviour()) ||
            ((key == "robot.lag_ms" || key == "sensor.lag_ms" || key == "sensor.tool_mass_kg") &&
             value_of(rig, key) == 0.0) ||
            (key.find("object.second") == 0 && value_of(rig, "object.second_mass_kg") == 0.0) ||
            (key.find("object.relaxation") == 0 && value_of(rig, "object.relaxation_stiffness_N_per_m") == 0.0) ||
            (key == "sensor.low_pass_frequency_Hz" && rig.sensor.low_pass_order == 0) ||
            (key == "sensor.low_pass_damping_ratio" && rig.sensor.low_pass_order < 2);
        if (!is_absent) {
            keys.push_back(key);
        }
    }
    return keys;
}

std::optional<rig_error> complete_and_check_steady(rig &rig)
{
    if (auto error = complete_and_check(rig)) {
        return error;
    }
    if (rig.has_wandering_samples()) {
        return rig_error{"sensor.rate_Hz",
                         "its period, in whole ns, does not go into that of this loop.rate_Hz: the "
                         "age of the force changes from period to period and there are no "
                         "eigenvalues"};
    }
    return {};
}

std::optional<rig> with_value(const rig &original, const rig_key &key, double value)
{
    rig changed = original;
    if (key.path == "robot.dead_time_ms") {
        move_dead_time(changed, value);
    } else {
        *static_cast<double *>(key.member(changed)) = value;
    }
    const bool in_range = value > key.low || (key.low_is_allowed && value == key.low);
    if (!in_range || complete_and_check_steady(changed)) {
        return {};
    }
    return changed;
}

rig at_rate(const rig &original, double rate_Hz, delays_stay delays)
{
    rig changed = original;
    changed.firmware.loop.rate_Hz = rate_Hz;
    if (delays == delays_stay::in_ticks) {
        const double factor = original.firmware.loop.rate_Hz / rate_Hz;
        for (const char *const delay : {"robot.dead_time_ms", "sensor.delay_ms", "sensor.sample_phase_ms"}) {
            set_number(changed, delay, value_of(original, delay) * factor);
        }
        changed.sensor.rate_Hz /= factor;
    }
    return changed;
}

double usual_value(const rig &rig, parameter_scale kind)
{
    const manipulator_config &m = rig.firmware.manipulator;
    const double stiffness = std::max({m.stiffness_N_per_m, rig.object.stiffness_N_per_m, 1.0});
    switch (kind) {
    case parameter_scale::stiffness:
        return stiffness;
    case parameter_scale::damping:
        return 0.1 * std::sqrt(stiffness * (m.mass_kg + rig.object.mass_kg));
    case parameter_scale::ratio:
        return 0.1;
    case parameter_scale::delay:
        return 1e3 * config_period_s(&rig.firmware);
    case parameter_scale::mass:
    case parameter_scale::frequency:
        break;
    }
    return 1.0;
}

} // namespace berth
