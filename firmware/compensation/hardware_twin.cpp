#include "hardware_twin.h"

#include <algorithm>
#include <cmath>

#include "../matrix_exponential.h"

namespace
{

constexpr int width = TWIN_STATES + TWIN_INPUTS;
constexpr int input = TWIN_STATES;
using row = Eigen::Matrix<double, 1, width>;
using square = Eigen::Matrix<double, width, width>;
using transition = Eigen::Matrix<double, TWIN_STATES, width, Eigen::RowMajor>;
using state_vector = Eigen::Matrix<double, TWIN_STATES, 1>;
using input_and_state = Eigen::Matrix<double, width, 1>;

/* A tool looks whether it touches this often in a tick. */
constexpr uint32_t twin_looks_a_tick = 8;

/* What reaches the sensor spring of the robot: position and velocity as rows of state and input. */
struct robot_rows {
    row position;
    row velocity;
};

robot_rows robot_of(const hardware_model &m)
{
    row position = row::Unit(input);
    row velocity = row::Unit(input + 1);
    if (m.robot_w_rad_per_s > 0.0) {
        position = row::Unit(TWIN_ROBOT_POSITION);
        velocity = row::Unit(TWIN_ROBOT_VELOCITY);
    }
    if (m.robot_lag_ms > 0.0) {
        velocity = (position - row::Unit(TWIN_ROBOT_LAG)) / (1e-3 * m.robot_lag_ms);
        position = row::Unit(TWIN_ROBOT_LAG);
    }
    return {position, velocity};
}

row spring_force(const hardware_model &m)
{
    const robot_rows robot = robot_of(m);
    return m.sensor_stiffness_N_per_m * (robot.position - row::Unit(TWIN_OBJECT_POSITION)) +
           m.sensor_damping_N_s_per_m * (robot.velocity - row::Unit(TWIN_OBJECT_VELOCITY));
}

row sample_of(const hardware_model &m)
{
    const row filtered = m.low_pass_order > 0 ? row(row::Unit(TWIN_LOW_PASS)) : spring_force(m);
    return m.sensor_gain * (m.sensor_lag_ms > 0.0 ? row(row::Unit(TWIN_SENSOR_LAG)) : filtered);
}

/* d/dt of state and input. What the hardware does not have stays as it is. */
square rates_of(const hardware_model &m, bool touches)
{
    square a = square::Zero();
    const row force = spring_force(m);
    a(TWIN_OBJECT_POSITION, TWIN_OBJECT_VELOCITY) = 1.0;
    a.row(TWIN_OBJECT_VELOCITY) = force / m.mass_kg;
    if (touches) {
        a(TWIN_OBJECT_VELOCITY, TWIN_OBJECT_POSITION) -= m.stiffness_N_per_m / m.mass_kg;
        a(TWIN_OBJECT_VELOCITY, TWIN_OBJECT_VELOCITY) -= m.damping_N_s_per_m / m.mass_kg;
    }
    const double w_low_pass = m.low_pass_w_rad_per_s;
    if (m.low_pass_order == 2) {
        a(TWIN_LOW_PASS, TWIN_LOW_PASS_RATE) = 1.0;
        a.row(TWIN_LOW_PASS_RATE) = w_low_pass * w_low_pass * (force - row::Unit(TWIN_LOW_PASS)) -
                                    2.0 * m.low_pass_damping_ratio * w_low_pass * row::Unit(TWIN_LOW_PASS_RATE);
    } else if (m.low_pass_order == 1) {
        a.row(TWIN_LOW_PASS) = w_low_pass * (force - row::Unit(TWIN_LOW_PASS));
    }
    if (m.robot_w_rad_per_s > 0.0) {
        const double w = m.robot_w_rad_per_s;
        a(TWIN_ROBOT_POSITION, TWIN_ROBOT_VELOCITY) = 1.0;
        a.row(TWIN_ROBOT_VELOCITY) = w * w * (row::Unit(input) - row::Unit(TWIN_ROBOT_POSITION)) -
                                     2.0 * m.robot_damping_ratio * w * row::Unit(TWIN_ROBOT_VELOCITY);
    }
    if (m.robot_lag_ms > 0.0) {
        a.row(TWIN_ROBOT_LAG) = robot_of(m).velocity;
    }
    if (m.sensor_lag_ms > 0.0) {
        const row filtered = m.low_pass_order > 0 ? row(row::Unit(TWIN_LOW_PASS)) : force;
        a.row(TWIN_SENSOR_LAG) = (filtered - row::Unit(TWIN_SENSOR_LAG)) / (1e-3 * m.sensor_lag_ms);
    }
    a(input, input + 1) = 1.0;
    return a;
}

/* What each state reaches where the object swings by 1 m on the sensor spring. In these units the exponential keeps
 * its digits: in N a low-pass behind a stiff spring is 1e9 times larger than what drives it. */
row natural_scales(const hardware_model &m)
{
    const double w = std::sqrt(m.sensor_stiffness_N_per_m / m.mass_kg);
    const double force_N = m.sensor_stiffness_N_per_m;
    row scales;
    scales << 1.0, w, force_N, force_N * std::max(1.0, m.low_pass_w_rad_per_s), 1.0,
        std::max(1.0, m.robot_w_rad_per_s), 1.0, force_N, 1.0, w;
    return scales;
}

void fill(twin_transition &made, const hardware_model &m, double duration_s)
{
    const row scales = natural_scales(m);
    for (const int touches : {0, 1}) {
        const square scaled = scales.cwiseInverse().asDiagonal() * rates_of(m, touches != 0) * scales.asDiagonal();
        const square over = berth::matrix_exponential<width>(scaled * duration_s);
        Eigen::Map<transition>(&made.of[touches][0][0]) =
            (scales.asDiagonal() * over * scales.cwiseInverse().asDiagonal()).topRows<TWIN_STATES>();
    }
}

/* Without transfer behaviour and lag the sensor's damper makes an impulse of a jump. */
void fill_jump(hardware_twin &twin)
{
    const hardware_model &m = twin.model;
    std::fill_n(twin.jump, TWIN_STATES, 0.0);
    if (m.robot_w_rad_per_s > 0.0 || m.robot_lag_ms > 0.0) {
        return;
    }
    const double impulse_N_s = m.sensor_damping_N_s_per_m;
    const double w = m.low_pass_w_rad_per_s;
    twin.jump[TWIN_OBJECT_VELOCITY] = impulse_N_s / m.mass_kg;
    if (m.low_pass_order == 2) {
        twin.jump[TWIN_LOW_PASS_RATE] = w * w * impulse_N_s;
    } else if (m.low_pass_order == 1) {
        twin.jump[TWIN_LOW_PASS] = w * impulse_N_s;
    } else if (m.sensor_lag_ms > 0.0) {
        twin.jump[TWIN_SENSOR_LAG] = impulse_N_s / (1e-3 * m.sensor_lag_ms);
    }
}

double delay_ticks(const hardware_model &m, double period_s)
{
    return 1e-3 * (m.setpoint_to_motion_ms + m.sample_age_ms) / period_s;
}

/* Everything at rest with the robot at `position_m`; a tool starts without touching. */
void rest_at(hardware_twin &twin, double position_m)
{
    const hardware_model &m = twin.model;
    const double stiffness_N_per_m = m.is_one_sided ? 0.0 : m.stiffness_N_per_m;
    const double x = m.sensor_stiffness_N_per_m / (m.sensor_stiffness_N_per_m + stiffness_N_per_m) * position_m;
    const double force_N = stiffness_N_per_m * x;
    twin.state[TWIN_OBJECT_POSITION] = x;
    twin.state[TWIN_LOW_PASS] = m.low_pass_order > 0 ? force_N : 0.0;
    twin.state[TWIN_ROBOT_POSITION] = twin.state[TWIN_ROBOT_LAG] = position_m;
    twin.state[TWIN_SENSOR_LAG] = m.sensor_lag_ms > 0.0 ? force_N : 0.0;
    twin.position_m = twin.before_m = position_m;
    past_fill(&twin.samples_N, m.sensor_gain * force_N);
}

struct line {
    double position_m;
    double velocity_m_per_s;
};

void advance(hardware_twin &twin, const twin_transition &change, uint32_t substeps, double substep_s, line &line)
{
    Eigen::Map<state_vector> state(twin.state);
    for (uint32_t i = 0; i < substeps; i++) {
        const int touches =
            hardware_touches(&twin.model, twin.state[TWIN_OBJECT_POSITION], twin.state[TWIN_OBJECT_VELOCITY]);
        input_and_state all;
        all << state, line.position_m, line.velocity_m_per_s;
        state = Eigen::Map<const transition>(&change.of[touches][0][0]).lazyProduct(all).eval();
        line.position_m += substep_s * line.velocity_m_per_s;
    }
}

double sample_N(const hardware_twin &twin, const line &line)
{
    input_and_state all;
    all << Eigen::Map<const state_vector>(twin.state), line.position_m, line.velocity_m_per_s;
    return Eigen::Map<const row>(twin.output).dot(all);
}

} // namespace

extern "C" {

int hardware_touches(const hardware_model *model, double depth_m, double velocity_m_per_s)
{
    return !model->is_one_sided ||
           (depth_m > 0.0 && model->stiffness_N_per_m * depth_m + model->damping_N_s_per_m * velocity_m_per_s > 0.0);
}

int hardware_twin_fits(const hardware_model *model, double period_s)
{
    return delay_ticks(*model, period_s) < PAST_TICKS - 1;
}

void hardware_twin_start(hardware_twin *twin, const hardware_model *model, double period_s, double position_m)
{
    *twin = {};
    twin->model = *model;
    twin->period_s = period_s;
    /* A delay within rounding of whole ticks is whole: the sample shows what the setpoint of its instant has done, a
     * jump or a new direction, and is taken at the begin of the tick that goes on from there. */
    constexpr double rounding = 1e-6;
    const double ticks = delay_ticks(*model, period_s);
    const auto whole = static_cast<uint32_t>(ticks + rounding);
    const double rest = ticks - static_cast<double>(whole);
    const bool is_at_begin = rest <= rounding && whole > 0;
    twin->delay_ticks = is_at_begin ? whole - 1 : whole;
    const double after_s = is_at_begin ? period_s : std::max(0.0, rest) * period_s;
    const double parts_s[] = {period_s - after_s, after_s};
    twin_transition *const transitions[] = {&twin->until_sample, &twin->after_sample};
    for (int i = 0; i < 2; i++) {
        const double looks = static_cast<double>(twin_looks_a_tick) * parts_s[i] / period_s;
        const uint32_t wanted = model->is_one_sided ? 1 + static_cast<uint32_t>(looks) : 1;
        twin->substeps[i] = parts_s[i] > 0.0 ? std::min<uint32_t>(wanted, TWIN_SUBSTEPS_MAX) : 0;
        twin->substep_s[i] = parts_s[i] / static_cast<double>(std::max<uint32_t>(twin->substeps[i], 1));
        fill(*transitions[i], *model, twin->substep_s[i]);
    }
    Eigen::Map<row>(twin->output) = sample_of(*model);
    fill_jump(*twin);
    rest_at(*twin, model->robot_gain * position_m - model->surface_m);
}

void hardware_twin_step(hardware_twin *twin, double setpoint_m)
{
    const hardware_model &m = twin->model;
    const double next_m = m.robot_gain * setpoint_m - m.surface_m;
    /* The sample that is due now was taken `delay_ticks` ago, and later in that tick if there is a rest. */
    line line{twin->position_m, m.holds ? 0.0 : (next_m - twin->position_m) / twin->period_s};
    if (m.holds) {
        const double jump_m = twin->position_m - twin->before_m;
        Eigen::Map<state_vector>(twin->state) += jump_m * Eigen::Map<const state_vector>(twin->jump);
    }
    advance(*twin, twin->until_sample, twin->substeps[0], twin->substep_s[0], line);
    past_add(&twin->samples_N, sample_N(*twin, line));
    advance(*twin, twin->after_sample, twin->substeps[1], twin->substep_s[1], line);
    twin->before_m = twin->position_m;
    twin->position_m = next_m;
}

double hardware_twin_sample(const hardware_twin *twin, double longer_ticks)
{
    if (longer_ticks == 0.0) {
        return past_tick(&twin->samples_N, twin->delay_ticks);
    }
    constexpr double most = PAST_TICKS_BEFORE_MAX;
    return past_before(&twin->samples_N,
                       std::clamp(static_cast<double>(twin->delay_ticks) + longer_ticks, 0.0, most));
}

double hardware_twin_robot_m(const hardware_twin *twin)
{
    const hardware_model &m = twin->model;
    return m.robot_lag_ms > 0.0        ? twin->state[TWIN_ROBOT_LAG]
           : m.robot_w_rad_per_s > 0.0 ? twin->state[TWIN_ROBOT_POSITION]
                                       : twin->position_m;
}
}
