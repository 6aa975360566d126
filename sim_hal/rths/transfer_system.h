/* The benchmark's hardware side: servo valve, hydraulic actuator, specimen, sensors and converters. */
#ifndef SIM_HAL_RTHS_TRANSFER_SYSTEM_H
#define SIM_HAL_RTHS_TRANSFER_SYSTEM_H

#include <cstdint>
#include <Eigen/Core>

#include "../hil/random.h"

namespace berth::rths
{

constexpr double rate_Hz = 4096.0;
constexpr double period_s = 1.0 / rate_Hz;

/* Nominal values. */
struct transfer_parameters {
    double specimen_mass_kg = 29.13;
    double specimen_stiffness_N_per_m = 1.19e6;
    double specimen_damping_ratio = 0.0097;
    double command_gain = 1.0261;
    double valve_gain = 2.1283e13;         /* a1 beta0, N / (m s^3) */
    double valve_rate_per_s = 425.0;       /* beta1 */
    double valve_spring_per_s2 = 9.9976e4; /* beta2 */
    double coupling_N_per_m = 4.2297e6;    /* a2: natural velocity feedback */
    double leakage_per_s = 3.3;            /* a3 */
    double force_limit_N = 8900.0;

    double specimen_damping_N_s_per_m() const;
};

/* What is another in every perturbed plant, with its standard deviation. */
struct uncertain_property {
    double transfer_parameters::*of;
    double deviation;
};
constexpr uncertain_property uncertain_properties[] = {{&transfer_parameters::specimen_stiffness_N_per_m, 5e4},
                                                       {&transfer_parameters::valve_rate_per_s, 3.3},
                                                       {&transfer_parameters::valve_spring_per_s2, 3.3e3},
                                                       {&transfer_parameters::leakage_per_s, 1.3}};
transfer_parameters perturbed(std::int64_t seed);

/* Standard deviation of a measured displacement. */
double position_noise_m();

struct measurement {
    double position_m;
    double force_N;
};

enum transfer_state_index { valve, valve_rate, force, position, velocity, transfer_states };
using transfer_state = Eigen::Matrix<double, transfer_states, 1>;
using transfer_matrix = Eigen::Matrix<double, transfer_states, transfer_states>;

/* x' = A x + B u without the force's limit, u: the command in m. */
transfer_matrix transfer_dynamics(const transfer_parameters &parameters);
transfer_state transfer_input(const transfer_parameters &parameters);

/* Clipped and rounded, as every converter does. */
double converted(double value);

class transfer_system
{
  public:
    /* Noise is white, one value a sample. `noise_scale` 0: none, and ideal converters. */
    transfer_system(const transfer_parameters &parameters, std::int64_t seed, double noise_scale);

    /* Of now. To be called once a sample: every sample has its own noise. */
    measurement measure();

    /* Holds the command for a sample. */
    void step(double command_m);

    const transfer_state &state() const { return state_; }

  private:
    transfer_parameters parameters_;
    transfer_matrix dynamics_;
    transfer_state input_;
    double noise_scale_;
    random_stream position_noise_;
    random_stream force_noise_;
    transfer_state state_ = transfer_state::Zero();
};

} // namespace berth::rths

#endif
