#include "compensation.h"

#include <float.h>
#include <stdbool.h>

static bool non_negative(double value)
{
    return value >= 0.0 && value <= DBL_MAX;
}

static bool positive(double value)
{
    return value > 0.0 && value <= DBL_MAX;
}

/* Not finite: the rig's own counts. */
static bool positive_or_none(double value)
{
    return value > 0.0;
}

static bool non_negative_or_none(double value)
{
    return value >= 0.0;
}

/* What is switched off refuses nothing: its defaults need not fit a rig that does without it. */
struct config_error compensation_validate(const struct app_config *config)
{
    static const char *const must_be_positive = "must be a finite number greater than 0";
    static const char *const must_not_be_negative = "must be a finite number, 0 or more";
    static const char *const must_be_positive_or_inf = "must be greater than 0, or inf: as the rig has it";
    static const char *const must_not_be_negative_or_inf = "must be 0 or more, or inf: as the rig has it";
    const struct extrapolation_config *extrapolation = &config->extrapolation;
    const struct prediction_config *prediction = &config->prediction;
    const struct adaptive_inverse_config *inverse = &config->adaptive_inverse;
    const struct force_lead_config *lead = &config->force_lead;
    const struct identification_config *identification = &config->identification;
    const struct passivity_config *passivity = &config->passivity;
    const double rate_Hz = config->loop.rate_Hz;
    const struct manipulator_config *manipulator = &config->manipulator;
    const double damping_max_N_s_per_m = 2.0 * manipulator->mass_kg * rate_Hz - manipulator->damping_N_s_per_m;
    const struct {
        bool fails;
        struct config_error error;
    } checks[] = {
        {extrapolation->order < 0 || extrapolation->order > EXTRAPOLATION_ORDER_MAX,
         {"extrapolation.order", "must be from 0 to 3"}},
        {!non_negative(extrapolation->delay_ms), {"extrapolation.delay_ms", must_not_be_negative}},
        {extrapolation->order > 0 && !extrapolation_fits(config),
         {"extrapolation.order", "times the delay must be less than 1022 ticks"}},
        {!(inverse->tolerance >= 0.0 && inverse->tolerance <= 0.33),
         {"adaptive_inverse.tolerance",
          "must be from 0 to 0.33: at three tolerances the delay must not be negative"}},
        {!(inverse->gain_tolerance >= 0.0 && inverse->gain_tolerance <= 0.3),
         {"adaptive_inverse.gain_tolerance", "must be from 0 to 0.3"}},
        {!positive(inverse->bandwidth_Hz) || (inverse->enabled && inverse->bandwidth_Hz > 0.1 * rate_Hz),
         {"adaptive_inverse.bandwidth_Hz", "must be greater than 0 and at most a tenth of the loop's rate"}},
        {!positive(inverse->position_noise_m), {"adaptive_inverse.position_noise_m", must_be_positive}},
        {!positive(inverse->memory_s), {"adaptive_inverse.memory_s", must_be_positive}},
        {!positive(inverse->correction_max_m), {"adaptive_inverse.correction_max_m", must_be_positive}},
        {inverse->enabled && !adaptive_inverse_fits(config),
         {"adaptive_inverse.enabled", "needs reports of the robot that are less than 1022 ticks old"}},
        {inverse->enabled && config->inverse_filter.enabled,
         {"adaptive_inverse.enabled", "must be false with inverse_filter.enabled = true: both would make up for the "
                                      "robot's transfer behaviour"}},
        {!non_negative(lead->age_ms), {"force_lead.age_ms", must_not_be_negative}},
        {!positive_or_none(lead->error_bandwidth_Hz),
         {"force_lead.error_bandwidth_Hz", "must be greater than 0, or inf: the model is corrected at once"}},
        {lead->enabled && prediction->enabled,
         {"force_lead.enabled", "must be false with prediction.enabled = true, which leads the force already"}},
        {lead->enabled && !force_lead_fits(config),
         {"force_lead.enabled", "needs a force that is less than 1022 ticks old"}},
        {!positive_or_none(prediction->dead_time_ms), {"prediction.dead_time_ms", must_be_positive_or_inf}},
        {!positive_or_none(prediction->mass_kg), {"prediction.mass_kg", must_be_positive_or_inf}},
        {!non_negative_or_none(prediction->damping_N_s_per_m),
         {"prediction.damping_N_s_per_m", must_not_be_negative_or_inf}},
        {!non_negative_or_none(prediction->stiffness_N_per_m),
         {"prediction.stiffness_N_per_m", must_not_be_negative_or_inf}},
        {!non_negative(prediction->error_bandwidth_Hz) ||
             (prediction->enabled && prediction->error_bandwidth_Hz > 0.5 * rate_Hz),
         {"prediction.error_bandwidth_Hz", "must be from 0 to half the rate of the loop"}},
        {prediction->enabled && !prediction_fits(config),
         {"prediction.enabled", "needs a dead time of less than 1023 ticks, setpoint to sample"}},
        {identification->enabled && !prediction->enabled,
         {"identification.enabled", "needs prediction.enabled = true: it corrects the prediction's model"}},
        {!(identification->tolerance > 0.0 && identification->tolerance <= 1.0),
         {"identification.tolerance", "must be greater than 0 and at most 1"}},
        {!positive(identification->noise_N), {"identification.noise_N", must_be_positive}},
        {!positive(identification->position_noise_m), {"identification.position_noise_m", must_be_positive}},
        {!positive(identification->memory_s), {"identification.memory_s", must_be_positive}},
        {!non_negative(config->dissipation.damping_N_s_per_m),
         {"dissipation.damping_N_s_per_m", must_not_be_negative}},
        {config->dissipation.damping_N_s_per_m > 0.0 &&
             config->dissipation.damping_N_s_per_m >= damping_max_N_s_per_m,
         {"dissipation.damping_N_s_per_m", "must be less than 2 mass times rate of the manipulator, less its own "
                                           "damping: a larger damper, a tick late, drives what it is to damp"}},
        {passivity->action < 0 || passivity->action >= PASSIVITY_ACTION_COUNT,
         {"passivity.action", "must be off, damping or tank"}},
        {passivity->reference < 0 || passivity->reference >= PASSIVITY_REFERENCE_COUNT,
         {"passivity.reference", "must be zero or measured"}},
        {!non_negative(passivity->credit_J), {"passivity.credit_J", must_not_be_negative}},
        {passivity->action == PASSIVITY_TANK && !positive(passivity->credit_J),
         {"passivity.credit_J", "must be greater than 0 with passivity.action = \"tank\": an empty tank lets no "
                                "force push the manipulator on"}},
        {!positive(passivity->horizon_ms), {"passivity.horizon_ms", must_be_positive}},
        {!non_negative(passivity->damping_max_N_s_per_m), {"passivity.damping_max_N_s_per_m", must_not_be_negative}},
        {passivity->action == PASSIVITY_DAMPING &&
             passivity->damping_max_N_s_per_m + config->dissipation.damping_N_s_per_m >= damping_max_N_s_per_m,
         {"passivity.damping_max_N_s_per_m",
          "must be less than 2 mass times rate of the manipulator, less its own damping and dissipation's: a larger "
          "damper, a tick late, drives what it is to damp"}},
        {!passivity_fits(config), {"passivity.reference", "measured needs a dead time of less than 1022 ticks"}},
    };
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++) {
        if (checks[i].fails) {
            return checks[i].error;
        }
    }
    return (struct config_error){NULL, NULL};
}

int compensation_is_on(const struct app_config *config)
{
    return config->extrapolation.order > 0 || config->adaptive_inverse.enabled || config->force_lead.enabled ||
           config->prediction.enabled || config->dissipation.damping_N_s_per_m > 0.0 ||
           config->passivity.action != PASSIVITY_OFF;
}

void compensation_start(struct compensation *compensation, const struct app_config *config,
                        const struct manipulator *manipulator)
{
    compensation->config = config;
    compensation->manipulator = manipulator;
    compensation->is_on = compensation_is_on(config) != 0;
    extrapolation_start(&compensation->extrapolation, config);
    if (config->adaptive_inverse.enabled) {
        const struct inverse_settings settings = inverse_settings_of(config);
        adaptive_inverse_start(&compensation->inverse, &settings, config->manipulator.initial_position_m);
    }
    if (config->force_lead.enabled) {
        const struct force_lead_settings settings = force_lead_settings_of(config);
        force_lead_start(&compensation->lead, &settings);
    }
    compensation->velocity_m_per_s = manipulator->velocity_m_per_s;
    prediction_start(&compensation->prediction, config, manipulator);
    passivity_start(&compensation->passivity, config);
}

void compensation_rest_at(struct compensation *compensation, double position_m)
{
    extrapolation_rest_at(&compensation->extrapolation, position_m);
    adaptive_inverse_rest_at(&compensation->inverse, position_m);
    force_lead_rest(&compensation->lead);
    compensation->velocity_m_per_s = 0.0;
}

double compensation_motion(struct compensation *compensation, double position_m)
{
    if (!compensation->is_on) {
        return position_m;
    }
    const double displayed_m = extrapolation_step(&compensation->extrapolation, position_m);
    return compensation->config->adaptive_inverse.enabled
               ? adaptive_inverse_follow(&compensation->inverse, displayed_m)
               : displayed_m;
}

static void learn(struct compensation *compensation, const struct prediction_input *in, int is_running)
{
    if (compensation->config->adaptive_inverse.enabled && is_running) {
        adaptive_inverse_learn(&compensation->inverse, in->setpoint_m, in->reported_m);
    } else {
        adaptive_inverse_pause(&compensation->inverse);
    }
}

static double led_force(struct compensation *compensation, double measured_N)
{
    const struct manipulator *manipulator = compensation->manipulator;
    const double period_s = compensation->lead.settings.period_s;
    const struct force_lead_motion motion = {
        .position_m = manipulator->position_m - compensation->lead.settings.model.surface_m,
        .velocity_m_per_s = manipulator->velocity_m_per_s,
        .acceleration_m_per_s2 = (manipulator->velocity_m_per_s - compensation->velocity_m_per_s) / period_s,
    };
    compensation->velocity_m_per_s = manipulator->velocity_m_per_s;
    return force_lead_step(&compensation->lead, &motion, measured_N);
}

double compensation_force(struct compensation *compensation, const struct operator_command *command,
                          const struct energy_sums *energy, const struct prediction_input *in, int is_running)
{
    const struct manipulator *manipulator = compensation->manipulator;
    const struct app_config *config = compensation->config;
    if (!compensation->is_on) {
        return in->measured_N;
    }
    learn(compensation, in, is_running);
    const double led_N = config->force_lead.enabled ? led_force(compensation, in->measured_N)
                                                    : prediction_step(&compensation->prediction, command, in);
    const double force_N =
        led_N + config->dissipation.damping_N_s_per_m * (manipulator->velocity_m_per_s - command->velocity_m_per_s);
    if (!is_running) {
        passivity_rest(&compensation->passivity);
        return force_N;
    }
    const struct passivity_energies energies = {energy->simulated_port_J, energy->measured_port_J};
    return passivity_step(&compensation->passivity, &energies, manipulator->position_m,
                          manipulator->velocity_m_per_s, force_N);
}
