#include "passivity.h"

/* From a force's origin back to the setpoint that led to it, in ticks. */
static double delay_ticks(const struct app_config *config)
{
    return 1e-3 * (config->hardware.setpoint_to_motion_ms + config->energy.force_age_ms) / config_period_s(config);
}

int passivity_fits(const struct app_config *config)
{
    return config->passivity.action == PASSIVITY_OFF || config->passivity.reference != PASSIVITY_MEASURED ||
           delay_ticks(config) < PAST_TICKS_BEFORE_MAX;
}

void passivity_start(struct passivity *passivity, const struct app_config *config)
{
    *passivity = (struct passivity){.config = &config->passivity};
    passivity->follows_measured = config->passivity.reference == PASSIVITY_MEASURED;
    passivity->delay_ticks = passivity->follows_measured ? delay_ticks(config) : 0.0;
    passivity->horizon_s = 1e-3 * config->passivity.horizon_ms;
    passivity_rest(passivity);
}

void passivity_rest(struct passivity *passivity)
{
    if (passivity->config->action == PASSIVITY_OFF) {
        return;
    }
    passivity->is_open = 0;
    passivity->taken_J = 0.0;
    passivity->force_N = 0.0;
    passivity->forgiven_J = -passivity->config->credit_J;
    passivity->deficit_J = -passivity->config->credit_J;
}

static void observe(struct passivity *passivity, const struct passivity_energies *energies, double position_m)
{
    if (!passivity->is_open) {
        past_fill(&passivity->given_J, energies->simulated_port_J);
        passivity->is_open = 1;
    } else {
        passivity->taken_J += passivity->force_N * (position_m - passivity->position_m);
    }
    past_add(&passivity->given_J, energies->simulated_port_J - passivity->taken_J);
    const double reference_J = passivity->follows_measured ? energies->measured_port_J : 0.0;
    const double deficit_J = reference_J - past_before(&passivity->given_J, passivity->delay_ticks) -
                             passivity->taken_J + passivity->forgiven_J;
    const double credit_J = passivity->config->credit_J;
    if (deficit_J < -credit_J) {
        passivity->forgiven_J -= deficit_J + credit_J;
    }
    passivity->deficit_J = deficit_J < -credit_J ? -credit_J : deficit_J;
}

static double damping_force(const struct passivity *passivity, double velocity_m_per_s)
{
    if (passivity->deficit_J <= 0.0) {
        return 0.0;
    }
    const double most = passivity->config->damping_max_N_s_per_m;
    const double square = velocity_m_per_s * velocity_m_per_s * passivity->horizon_s;
    const double damping = passivity->deficit_J < most * square ? passivity->deficit_J / square : most;
    return damping * velocity_m_per_s;
}

/* The valve closes over the last tenth of the credit. */
static double valve_force(const struct passivity *passivity, double velocity_m_per_s, double force_N)
{
    if (force_N * velocity_m_per_s >= 0.0) {
        return 0.0;
    }
    const double lowest_J = 0.1 * passivity->config->credit_J;
    const double left_J = -passivity->deficit_J;
    const double open = left_J >= lowest_J ? 1.0 : left_J > 0.0 ? left_J / lowest_J : 0.0;
    return (open - 1.0) * force_N;
}

double passivity_step(struct passivity *passivity, const struct passivity_energies *energies, double position_m,
                      double velocity_m_per_s, double force_N)
{
    if (passivity->config->action == PASSIVITY_OFF) {
        return force_N;
    }
    observe(passivity, energies, position_m);
    passivity->position_m = position_m;
    passivity->force_N = passivity->config->action == PASSIVITY_DAMPING
                             ? damping_force(passivity, velocity_m_per_s)
                             : valve_force(passivity, velocity_m_per_s, force_N);
    return force_N + passivity->force_N;
}
