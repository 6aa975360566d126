#include "energy_account.h"

#include "matrix_exponential.h"

namespace
{

using vector2 = Eigen::Matrix<double, 2, 1>;
using vector3 = Eigen::Matrix<double, 3, 1>;
using vector4 = Eigen::Matrix<double, 4, 1>;
using matrix2 = Eigen::Matrix<double, 2, 2, Eigen::RowMajor>;
using matrix23 = Eigen::Matrix<double, 2, 3, Eigen::RowMajor>;
using matrix4 = Eigen::Matrix<double, 4, 4>;
using matrix8 = Eigen::Matrix<double, 8, 8>;

double stored_J(const manipulator_config &c, double position_m, double velocity_m_per_s, double operator_position_m)
{
    const double stretch_m = position_m - operator_position_m;
    return 0.5 * (c.mass_kg * velocity_m_per_s * velocity_m_per_s + c.stiffness_N_per_m * stretch_m * stretch_m);
}

/* Integral over a period of D (v - v_op)^2 as a form of the state at its begin (Van Loan 1978). */
matrix4 loss_form(const manipulator_config &c, double period_s)
{
    matrix4 a = matrix4::Zero();
    a(0, 1) = 1.0;
    a.row(1) << -c.stiffness_N_per_m, -c.damping_N_s_per_m, 1.0, c.damping_N_s_per_m;
    a.row(1) /= c.mass_kg;
    matrix4 power = matrix4::Zero();
    power(1, 1) = power(3, 3) = c.damping_N_s_per_m;
    power(1, 3) = power(3, 1) = -c.damping_N_s_per_m;
    matrix8 both = matrix8::Zero();
    both.topLeftCorner<4, 4>() = -a.transpose();
    both.topRightCorner<4, 4>() = power;
    both.bottomRightCorner<4, 4>() = a;
    const matrix8 exponential = berth::matrix_exponential<8>(both * period_s);
    return exponential.bottomRightCorner<4, 4>().transpose() * exponential.topRightCorner<4, 4>();
}

/* What neither stays in an arm nor goes through its port has come from its joints and its satellite: its integrator
 * makes nothing of a constant force. */
void book_arm_step(energy_account &account)
{
    const manipulator &now = *account.manipulator;
    energy_sums &sums = account.sums;
    const double way_m = now.position_m - account.position_m;
    double given_J = now.arm.acting.force_N * way_m;
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        given_J += now.arm.acting.side[i] * (now.arm.side[i] - account.side_begin[i]);
    }
    const double stored_J = manipulator_stored_J(&now, 0.0);
    sums.operator_J += stored_J - sums.stored_J + given_J;
    sums.simulated_port_J += given_J;
    sums.compensation_J -= (account.force_N - account.measured_N) * way_m;
    sums.stored_J = stored_J;
}

/* The step that has gone by: from the remembered state to the manipulator's. */
void book_step(energy_account &account)
{
    const manipulator &now = *account.manipulator;
    if (now.has_arm) {
        book_arm_step(account);
        return;
    }
    const manipulator_config &c = *now.config;
    const operator_command &held = account.command;
    energy_sums &sums = account.sums;
    const vector3 input(held.position_m, held.velocity_m_per_s, held.force_N - account.force_N);
    const vector2 before(account.position_m, account.velocity_m_per_s);
    const vector4 e(before(0) - held.position_m, before(1), input(2), held.velocity_m_per_s);
    const double dissipated_J = e.dot(Eigen::Map<const matrix4>(account.loss) * e);
    const double begin_J = sums.stored_J; /* as book_command() or the beginning left it */
    const double end_J = manipulator_stored_J(&now, held.position_m);
    const double way_m = now.position_m - before(0);
    double exact_J = end_J;
    double exact_way_m = way_m;
    if (c.integrator != INTEGRATOR_EXACT) {
        const vector2 exact =
            Eigen::Map<const matrix2>(now.transition) * before + Eigen::Map<const matrix23>(now.input_map) * input;
        exact_J = stored_J(c, exact(0), exact(1), held.position_m);
        exact_way_m = exact(0) - before(0);
        sums.integrator_J += end_J - exact_J + account.force_N * (now.position_m - exact(0));
    }
    sums.dissipated_J += dissipated_J;
    sums.operator_J += exact_J - begin_J + dissipated_J + account.force_N * exact_way_m;
    sums.simulated_port_J += account.force_N * way_m;
    sums.compensation_J -= (account.force_N - account.measured_N) * way_m;
    sums.stored_J = end_J;
}

/* The operator takes the spring's other end elsewhere from one tick to the next. */
void book_command(energy_account &account, const operator_command &command)
{
    const manipulator &now = *account.manipulator;
    const double moved_J = manipulator_stored_J(&now, command.position_m);
    account.sums.operator_J += moved_J - account.sums.stored_J;
    account.sums.stored_J = moved_J;
}

/* Work at one port between two ticks, force and position brought to one instant: the trapezoidal rule. */
double measured_work_J(const energy_account &account, energy_port &port, double force, double position)
{
    const bool force_is_older = account.lag_ticks >= 0.0;
    const double lag_ticks = force_is_older ? account.lag_ticks : -account.lag_ticks;
    const double fresher = force_is_older ? position : force;
    if (!account.is_filled) {
        past_fill(&port.kept, fresher);
    }
    past_add(&port.kept, fresher);
    const double kept = past_before(&port.kept, lag_ticks);
    const double paired_force = force_is_older ? force : kept;
    const double paired_position = force_is_older ? kept : position;
    const double work_J = 0.5 * (paired_force + port.paired_force) * (paired_position - port.paired_position);
    port.paired_force = paired_force;
    port.paired_position = paired_position;
    return work_J;
}

void book_measured(energy_account &account, double force_N, double position_m, bool goes_on)
{
    double work_J = measured_work_J(account, account.ports[0], force_N, position_m);
    for (uint32_t i = 1; i < account.port_count; i++) {
        work_J += measured_work_J(account, account.ports[i], account.measured_sides.force[i - 1],
                                  account.measured_sides.position[i - 1]);
    }
    account.is_filled = 1;
    if (goes_on) {
        account.sums.measured_port_J += work_J;
    }
}

} // namespace

extern "C" {

void energy_account_start(energy_account *account, const app_config *config, const manipulator *manipulator)
{
    *account = {};
    account->manipulator = manipulator;
    const double period_s = config_period_s(config);
    const double position_age_s =
        config->energy.position_age_ms > 0.0 ? 1e-3 * config->energy.position_age_ms : period_s;
    account->lag_ticks = (1e-3 * config->energy.force_age_ms - position_age_s) / period_s;
    constexpr double lag_max = ENERGY_LAG_TICKS_MAX;
    account->is_measuring = account->lag_ticks <= lag_max && account->lag_ticks >= -lag_max;
    account->port_count = manipulator->arm.has_sides ? ENERGY_PORTS_MAX : 1;
    Eigen::Map<matrix4>(account->loss) = loss_form(config->manipulator, period_s);
}

void energy_account_book(energy_account *account, const operator_command *command, double measured_N,
                         double robot_position_m, double displaced_m, int is_running)
{
    const manipulator &now = *account->manipulator;
    energy_sums &sums = account->sums;
    const bool goes_on = account->is_open && is_running;
    if (goes_on) {
        book_step(*account);
        sums.compensation_J += account->measured_N * (displaced_m - account->displaced_m);
        book_command(*account, *command);
    } else if (is_running) {
        sums = {};
        sums.stored_J = manipulator_stored_J(&now, command->position_m);
    }
    account->displaced_m = displaced_m;
    if (account->is_measuring) {
        book_measured(*account, measured_N, robot_position_m, goes_on);
        sums.dead_time_J = sums.measured_port_J - sums.simulated_port_J - sums.compensation_J;
    }
}

void energy_account_announce(energy_account *account, const operator_command *command, double force_N,
                             double measured_N, int is_running)
{
    const manipulator &now = *account->manipulator;
    account->is_open = is_running != 0;
    account->position_m = now.position_m;
    account->velocity_m_per_s = now.velocity_m_per_s;
    account->command = *command;
    account->force_N = force_N;
    account->measured_N = measured_N;
    for (int i = 0; now.has_arm && i < SIDE_AXIS_COUNT; i++) {
        account->side_begin[i] = now.arm.side[i];
    }
}

void energy_account_sides(energy_account *account, const energy_sides *sides)
{
    account->measured_sides = *sides;
}
}
