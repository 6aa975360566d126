#include "manipulator.h"

#include "matrix_exponential.h"

namespace
{

using vector2 = Eigen::Matrix<double, 2, 1>;
using vector3 = Eigen::Matrix<double, 3, 1>;
using matrix2 = Eigen::Matrix<double, 2, 2, Eigen::RowMajor>;
using matrix23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using matrix5 = Eigen::Matrix<double, 5, 5>;

vector3 input_vector(const operator_command &command, double force_N)
{
    return {command.position_m, command.velocity_m_per_s, command.force_N - force_N};
}

/* (x, v)' for the state (x, v). */
vector2 derivative(const manipulator_config &config, const vector2 &state, const vector3 &input)
{
    const double force = config.stiffness_N_per_m * (input(0) - state(0)) +
                         config.damping_N_s_per_m * (input(1) - state(1)) + input(2);
    return {state(1), force / config.mass_kg};
}

vector2 semi_implicit_euler(const manipulator_config &config, const vector2 &state, const vector3 &input,
                            double step_s)
{
    const double velocity = state(1) + step_s * derivative(config, state, input)(1);
    return {state(0) + step_s * velocity, velocity};
}

vector2 rk4(const manipulator_config &config, const vector2 &state, const vector3 &input, double step_s)
{
    const vector2 k1 = derivative(config, state, input);
    const vector2 k2 = derivative(config, state + 0.5 * step_s * k1, input);
    const vector2 k3 = derivative(config, state + 0.5 * step_s * k2, input);
    const vector2 k4 = derivative(config, state + step_s * k3, input);
    return state + step_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

void follow_arm(manipulator &manipulator)
{
    manipulator.position_m = manipulator.arm.position_m;
    manipulator.velocity_m_per_s = manipulator.arm.velocity_m_per_s;
}

} // namespace

extern "C" {

void manipulator_start(manipulator *manipulator, const app_config *config)
{
    const manipulator_config &c = config->manipulator;
    *manipulator = {};
    manipulator->config = &c;
    manipulator->position_m = c.initial_position_m;
    manipulator->velocity_m_per_s = c.initial_velocity_m_per_s;
    manipulator->step_s = config_period_s(config) / static_cast<double>(c.substeps);

    const double k = c.stiffness_N_per_m / c.mass_kg;
    const double d = c.damping_N_s_per_m / c.mass_kg;
    matrix5 a = matrix5::Zero();
    a(0, 1) = 1.0;
    a.row(1) << -k, -d, k, d, 1.0 / c.mass_kg;
    const matrix5 exponential = berth::matrix_exponential<5>(a * config_period_s(config));
    Eigen::Map<matrix2>(manipulator->transition) = exponential.topLeftCorner<2, 2>();
    Eigen::Map<matrix23>(manipulator->input_map) = exponential.topRightCorner<2, 3>();

    manipulator->has_arm = config->arm.kind != ARM_NONE;
    if (manipulator->has_arm) {
        const double direction[3] = {c.direction_x, c.direction_y, c.direction_z};
        arm_motion_start(&manipulator->arm, &config->arm, direction, c.initial_position_m, config_period_s(config));
        manipulator->arm.leads_force = config_leads_force(config) != 0;
        for (const side_axis_config &axis : config->side_axes) {
            manipulator->arm.has_sides |= axis.enabled != 0;
        }
        follow_arm(*manipulator);
    }
}

void manipulator_rest_at(manipulator *manipulator, double position_m)
{
    manipulator->position_m = position_m;
    manipulator->velocity_m_per_s = 0.0;
    if (manipulator->has_arm) {
        arm_motion_rest_at(&manipulator->arm, position_m);
    }
}

void manipulator_sides(const manipulator *manipulator, double side[SIDE_AXIS_COUNT])
{
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        side[i] = manipulator->arm.side[i];
    }
}

void manipulator_call_sides(manipulator *manipulator, const double side[SIDE_AXIS_COUNT])
{
    if (manipulator->has_arm) {
        arm_motion_call_sides(&manipulator->arm, side);
    }
}

void manipulator_load_sides(manipulator *manipulator, const double load[SIDE_AXIS_COUNT])
{
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        manipulator->arm.side_load[i] = load[i];
    }
}

double manipulator_stored_J(const manipulator *manipulator, double operator_position_m)
{
    if (manipulator->has_arm) {
        return manipulator->arm.stored_J;
    }
    const manipulator_config &c = *manipulator->config;
    const double stretch_m = manipulator->position_m - operator_position_m;
    return 0.5 * (c.mass_kg * manipulator->velocity_m_per_s * manipulator->velocity_m_per_s +
                  c.stiffness_N_per_m * stretch_m * stretch_m);
}

void manipulator_step(manipulator *manipulator, const operator_command *command, double force_N)
{
    if (manipulator->has_arm) {
        arm_motion_step(&manipulator->arm, command, force_N);
        follow_arm(*manipulator);
        return;
    }
    const manipulator_config &config = *manipulator->config;
    const vector3 input = input_vector(*command, force_N);
    vector2 state(manipulator->position_m, manipulator->velocity_m_per_s);
    if (config.integrator == INTEGRATOR_EXACT) {
        const Eigen::Map<const matrix2> transition(manipulator->transition);
        const Eigen::Map<const matrix23> input_map(manipulator->input_map);
        state = (transition * state + input_map * input).eval();
    } else {
        const auto step = config.integrator == INTEGRATOR_RK4 ? rk4 : semi_implicit_euler;
        for (int64_t i = 0; i < config.substeps; i++) {
            state = step(config, state, input, manipulator->step_s);
        }
    }
    manipulator->position_m = state(0);
    manipulator->velocity_m_per_s = state(1);
}
}
