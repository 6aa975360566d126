#include "prediction.h"

#include <algorithm>
#include <cmath>

#include "../matrix_exponential.h"
#include "../pi.h"

namespace
{

using coupled_step = Eigen::Matrix<double, 2, 5, Eigen::RowMajor>;
using matrix5 = Eigen::Matrix<double, 5, 5>;

constexpr uint32_t looks_a_tick = 8; /* of a tool, whether it touches */

/* The rig's model, but for what [prediction] says otherwise. */
hardware_model model_of(const app_config &config)
{
    const prediction_config &c = config.prediction;
    const auto otherwise = [](double own, double of_the_rig) { return std::isfinite(own) ? own : of_the_rig; };
    hardware_model model = config.hardware;
    model.setpoint_to_motion_ms = otherwise(c.dead_time_ms, model.setpoint_to_motion_ms);
    model.mass_kg = otherwise(c.mass_kg, model.mass_kg);
    model.damping_N_s_per_m = otherwise(c.damping_N_s_per_m, model.damping_N_s_per_m);
    model.stiffness_N_per_m = otherwise(c.stiffness_N_per_m, model.stiffness_N_per_m);
    return model;
}

/* What the manipulator feels of the object through the sensor spring, which gives way: as one that hangs on rigidly,
 * right at the frequency w of both together, where the object goes the share g of the way:
 *     Z k_S / (k_S + Z) = k' + d' s + m' s^2 + ...,   Z = k + d s + m s^2 */
hardware_model behind_sensor_spring(const manipulator_config &arm, const hardware_model &m)
{
    const double w_squared = (arm.stiffness_N_per_m + m.stiffness_N_per_m) / (arm.mass_kg + m.mass_kg);
    /* At most twice the way: beyond, the object would swing on the sensor, against the manipulator. */
    const double z_N_per_m =
        std::max(m.stiffness_N_per_m - m.mass_kg * w_squared, -0.5 * m.sensor_stiffness_N_per_m);
    const double g = m.sensor_stiffness_N_per_m / (m.sensor_stiffness_N_per_m + z_N_per_m);
    hardware_model felt = m;
    felt.mass_kg = g * g * m.mass_kg;
    felt.damping_N_s_per_m = g * g * m.damping_N_s_per_m + (1.0 - g) * (1.0 - g) * m.sensor_damping_N_s_per_m;
    felt.stiffness_N_per_m = g * z_N_per_m + felt.mass_kg * w_squared;
    return felt;
}

/* (M + m) x'' = F_op - error - D (x' - v_op) - K (x - x_op) - d x' - k x, the last two where it touches. */
coupled_step coupled_over(const manipulator_config &arm, hardware_model m, bool touches, double duration_s)
{
    if (!touches) {
        m.stiffness_N_per_m = m.damping_N_s_per_m = 0.0;
    }
    m = behind_sensor_spring(arm, m);
    const double k = m.stiffness_N_per_m;
    const double d = m.damping_N_s_per_m;
    matrix5 a = matrix5::Zero();
    a(0, 1) = 1.0;
    a.row(1) << -arm.stiffness_N_per_m - k, -arm.damping_N_s_per_m - d, arm.stiffness_N_per_m, arm.damping_N_s_per_m,
        1.0;
    a.row(1) /= arm.mass_kg + m.mass_kg;
    return berth::matrix_exponential<5>(a * duration_s).topRows<2>();
}

/* The constant force that gives the manipulator this velocity at the end of its step. */
double force_for(const manipulator &now, const operator_command &command, double velocity_m_per_s)
{
    const double *t = now.transition;
    const double *b = now.input_map;
    const double without_m_per_s = t[2] * now.position_m + t[3] * now.velocity_m_per_s + b[3] * command.position_m +
                                   b[4] * command.velocity_m_per_s;
    return command.force_N - (velocity_m_per_s - without_m_per_s) / b[5];
}

double model_force_N(const prediction &p, const operator_command &command)
{
    const manipulator &now = *p.manipulator;
    const hardware_model &m = p.twin.model;
    const double surface_m = m.surface_m;
    double x = now.position_m - surface_m;
    double v = now.velocity_m_per_s;
    for (uint32_t i = 0; i < p.substeps; i++) {
        const int touches = hardware_touches(&m, x, v);
        Eigen::Matrix<double, 5, 1> all;
        all << x, v, command.position_m - surface_m, command.velocity_m_per_s,
            command.force_N - p.fed_back_N - p.identified_N;
        const Eigen::Matrix<double, 2, 1> next = Eigen::Map<const coupled_step>(p.coupled[touches]).lazyProduct(all);
        x = next(0);
        v = next(1);
    }
    return force_for(now, command, v);
}

/* At the middle of the coming tick. */
double identified_force_N(const prediction &p)
{
    const manipulator &now = *p.manipulator;
    const double acceleration = (now.velocity_m_per_s - p.velocity_m_per_s) / p.period_s;
    const double half_s = 0.5 * p.period_s;
    return identification_force(&p.identification, &p.twin.model,
                                now.position_m - p.twin.model.surface_m + half_s * now.velocity_m_per_s,
                                now.velocity_m_per_s + half_s * acceleration, acceleration);
}

} // namespace

extern "C" {

int prediction_fits(const app_config *config)
{
    const hardware_model model = model_of(*config);
    return hardware_twin_fits(&model, config_period_s(config));
}

void prediction_start(prediction *prediction, const app_config *config, const manipulator *manipulator)
{
    *prediction = {};
    prediction->enabled = config->prediction.enabled;
    prediction->manipulator = manipulator;
    if (!prediction->enabled) {
        return;
    }
    const double period_s = config_period_s(config);
    const hardware_model model = model_of(*config);
    hardware_twin_start(&prediction->twin, &model, period_s, config->manipulator.initial_position_m);
    identification_start(&prediction->identification, config, &model);
    dead_time_tracker_start(&prediction->tracker, config, &model);
    prediction->period_s = period_s;
    prediction->velocity_m_per_s = manipulator->velocity_m_per_s;
    prediction->force_max_N = config->sensor_channel.force_limit_N;
    Eigen::Matrix<double, 1, 1> decay;
    decay << -berth::two_pi * config->prediction.error_bandwidth_Hz * period_s;
    prediction->error_share = 1.0 - berth::matrix_exponential<1>(decay)(0, 0);
    prediction->substeps = model.is_one_sided ? looks_a_tick : 1;
    for (const int touches : {0, 1}) {
        Eigen::Map<coupled_step>(prediction->coupled[touches]) = coupled_over(
            config->manipulator, model, touches != 0, period_s / static_cast<double>(prediction->substeps));
    }
}

believed_hardware prediction_belief(const prediction *prediction)
{
    const hardware_model &told = prediction->twin.model;
    const struct identification &id = prediction->identification;
    const auto more = [&](int property) { return id.share[property] * id.scales[property]; };
    return {told.mass_kg + more(IDENTIFIED_MASS), told.damping_N_s_per_m + more(IDENTIFIED_DAMPING),
            told.stiffness_N_per_m + more(IDENTIFIED_STIFFNESS),
            told.setpoint_to_motion_ms + 1e3 * prediction->tracker.longer_s};
}

double prediction_step(prediction *prediction, const operator_command *command, const prediction_input *in)
{
    if (!prediction->enabled) {
        return in->measured_N;
    }
    struct prediction &p = *prediction;
    hardware_twin_step(&p.twin, in->setpoint_m);
    const double longer_ticks = dead_time_tracker_step(&p.tracker, &p.twin, in->reported_m);
    p.error_N = in->measured_N - hardware_twin_sample(&p.twin, longer_ticks);
    const double rest_N = identification_step(&p.identification, &p.twin, longer_ticks, p.error_N);
    p.fed_back_N += p.error_share * (rest_N - p.fed_back_N);
    p.identified_N = identified_force_N(p);
    p.velocity_m_per_s = p.manipulator->velocity_m_per_s;
    const double wanted_N = model_force_N(p, *command);
    p.force_N = std::clamp(wanted_N, -p.force_max_N, p.force_max_N);
    p.saturated += p.force_N != wanted_N;
    return p.force_N;
}
}
