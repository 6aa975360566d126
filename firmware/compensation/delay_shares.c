#include "delay_shares.h"

/* The force lead leads the force to the middle of the tick that it is held by itself. */
static double held_ms(const struct app_config *config)
{
    return 1e3 * config_force_hold_s(config);
}

static double force_part_ms(const struct app_config *config)
{
    return config->energy.force_age_ms + config->hardware.sensor_lag_ms + held_ms(config);
}

/* Not what the adaptive inverse makes up for. */
static double left_by_inverse_ms(const struct app_config *config)
{
    return config->adaptive_inverse.enabled ? force_part_ms(config) : config->hardware.loop_delay_ms;
}

static double or_zero(double value)
{
    return value > 0.0 ? value : 0.0;
}

double extrapolation_delay_ms(const struct app_config *config)
{
    if (config->extrapolation.delay_ms > 0.0) {
        return config->extrapolation.delay_ms;
    }
    const double left_ms = left_by_inverse_ms(config);
    if (config->force_lead.enabled && config->force_lead.age_ms > 0.0) {
        return or_zero(left_ms - config->force_lead.age_ms - held_ms(config));
    }
    return config->force_lead.enabled || config->prediction.enabled ? or_zero(left_ms - force_part_ms(config))
                                                                    : left_ms;
}

double force_lead_age_ms(const struct app_config *config)
{
    if (config->force_lead.age_ms > 0.0) {
        return config->force_lead.age_ms;
    }
    const double extrapolated_ms = config->extrapolation.order > 0 ? extrapolation_delay_ms(config) : 0.0;
    return or_zero(left_by_inverse_ms(config) - held_ms(config) - extrapolated_ms);
}
