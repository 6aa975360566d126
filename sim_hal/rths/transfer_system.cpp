#include "transfer_system.h"

#include <algorithm>
#include <cmath>

#include "runge_kutta.h"

namespace berth::rths
{

namespace
{

/* Noise power of the benchmark, over one sample. */
const double force_noise_N = std::sqrt(1.16e-3 * rate_Hz);

enum stream : std::uint32_t { stream_position = 100, stream_force, stream_parameters };

} // namespace

double position_noise_m()
{
    static const double deviation_m = std::sqrt(6.25e-14 * rate_Hz);
    return deviation_m;
}

double transfer_parameters::specimen_damping_N_s_per_m() const
{
    return 2.0 * specimen_damping_ratio * std::sqrt(specimen_stiffness_N_per_m * specimen_mass_kg);
}

transfer_parameters perturbed(std::int64_t seed)
{
    random_stream draw(seed, stream_parameters);
    transfer_parameters parameters;
    for (const uncertain_property &property : uncertain_properties) {
        parameters.*property.of += property.deviation * draw.normal();
    }
    return parameters;
}

transfer_matrix transfer_dynamics(const transfer_parameters &parameters)
{
    const double mass_kg = parameters.specimen_mass_kg;
    transfer_matrix dynamics = transfer_matrix::Zero();
    dynamics(valve, valve_rate) = 1.0;
    dynamics(valve_rate, valve) = -parameters.valve_spring_per_s2;
    dynamics(valve_rate, valve_rate) = -parameters.valve_rate_per_s;
    dynamics(valve_rate, position) = -parameters.valve_gain;
    dynamics(force, valve) = 1.0;
    dynamics(force, force) = -parameters.leakage_per_s;
    dynamics(force, velocity) = -parameters.coupling_N_per_m;
    dynamics(position, velocity) = 1.0;
    dynamics(velocity, force) = 1.0 / mass_kg;
    dynamics(velocity, position) = -parameters.specimen_stiffness_N_per_m / mass_kg;
    dynamics(velocity, velocity) = -parameters.specimen_damping_N_s_per_m() / mass_kg;
    return dynamics;
}

transfer_state transfer_input(const transfer_parameters &parameters)
{
    transfer_state input = transfer_state::Zero();
    input(valve_rate) = parameters.command_gain * parameters.valve_gain;
    return input;
}

double converted(double value)
{
    constexpr double limit = 3.8;
    constexpr double steps_per_unit = 262144.0; /* 2^18 */
    return std::round(std::clamp(value, -limit, limit) * steps_per_unit) / steps_per_unit;
}

transfer_system::transfer_system(const transfer_parameters &parameters, std::int64_t seed, double noise_scale)
    : parameters_(parameters), dynamics_(transfer_dynamics(parameters)), input_(transfer_input(parameters)),
      noise_scale_(noise_scale), position_noise_(seed, stream_position), force_noise_(seed, stream_force)
{
}

measurement transfer_system::measure()
{
    if (noise_scale_ == 0.0) {
        return {state_(position), state_(force)};
    }
    return {converted(state_(position) + noise_scale_ * position_noise_m() * position_noise_.normal()),
            state_(force) + noise_scale_ * force_noise_N * force_noise_.normal()};
}

void transfer_system::step(double command_m)
{
    const double taken_m = noise_scale_ == 0.0 ? command_m : converted(command_m);
    const double limit_N = parameters_.force_limit_N;
    state_ = runge_kutta_step(state_, period_s, [&](const transfer_state &state, double) -> transfer_state {
        transfer_state clipped = state;
        clipped(force) = std::clamp(state(force), -limit_N, limit_N);
        return dynamics_ * clipped + input_ * taken_m;
    });
    state_(force) = std::clamp(state_(force), -limit_N, limit_N);
}

} // namespace berth::rths
