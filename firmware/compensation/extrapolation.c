#include "extrapolation.h"

#include "delay_shares.h"

static double delay_ticks(const struct app_config *config)
{
    return 1e-3 * extrapolation_delay_ms(config) / config_period_s(config);
}

int extrapolation_fits(const struct app_config *config)
{
    return delay_ticks(config) * (double)config->extrapolation.order < PAST_TICKS_BEFORE_MAX;
}

void extrapolation_start(struct extrapolation *extrapolation, const struct app_config *config)
{
    *extrapolation = (struct extrapolation){.order = (uint32_t)config->extrapolation.order};
    if (extrapolation->order > 0) {
        extrapolation->delay_ticks = delay_ticks(config);
        extrapolation_rest_at(extrapolation, config->manipulator.initial_position_m);
    }
}

void extrapolation_rest_at(struct extrapolation *extrapolation, double position_m)
{
    past_fill(&extrapolation->past_m, position_m);
}

double extrapolation_step(struct extrapolation *extrapolation, double position_m)
{
    /* (-1)^i C(n + 1, i + 1) */
    static const double weights[EXTRAPOLATION_ORDER_MAX + 1][EXTRAPOLATION_ORDER_MAX + 1] = {
        {1.0, 0.0, 0.0, 0.0},
        {2.0, -1.0, 0.0, 0.0},
        {3.0, -3.0, 1.0, 0.0},
        {4.0, -6.0, 4.0, -1.0},
    };
    if (extrapolation->order == 0) {
        return position_m;
    }
    past_add(&extrapolation->past_m, position_m);
    double setpoint_m = weights[extrapolation->order][0] * position_m;
    for (uint32_t i = 1; i <= extrapolation->order; i++) {
        setpoint_m += weights[extrapolation->order][i] *
                      past_before(&extrapolation->past_m, (double)i * extrapolation->delay_ticks);
    }
    return setpoint_m;
}
