#include "reflexes.h"

#include <float.h>

double following_delay_ticks(const struct app_config *config)
{
    const struct hardware_model *hardware = &config->hardware;
    const double w = hardware->robot_w_rad_per_s;
    const double lag_ms = hardware->robot_lag_ms + (w > 0.0 ? 2e3 * hardware->robot_damping_ratio / w : 0.0);
    const double age_ms = hardware->setpoint_to_motion_ms + hardware->report_age_ms + lag_ms;
    const double ticks = 1e-3 * age_ms * config->loop.rate_Hz - 1.0;
    return ticks > 0.0 ? ticks : 0.0;
}

static double weight_of_tick(double window_s, const struct app_config *config)
{
    const double weight = config_period_s(config) / window_s;
    return weight < 1.0 ? weight : 1.0;
}

void reflexes_start(struct reflexes *reflexes, const struct app_config *config)
{
    const struct reflex_config *c = &config->reflex;
    const double samples_per_tick = (double)config_period_ns(config) / (double)config_sample_period_ns(config);
    *reflexes = (struct reflexes){
        .following = {.limit_m = c->following_error_m,
                      .lasts_after_ns = ns_from_ms(c->following_error_ms),
                      .delay_ticks = following_delay_ticks(config)},
        .quality = {.least = c->link_quality,
                    .weight = weight_of_tick(c->link_quality_window_s, config),
                    .feedback_share = 1.0,
                    .sensor_share = 1.0,
                    .samples_per_tick = samples_per_tick < 1.0 ? samples_per_tick : 1.0},
        .power = {.limit_W = c->dead_time_power_W,
                  .weight = weight_of_tick(c->dead_time_power_window_s, config),
                  .period_s = config_period_s(config)},
        .growth = {.limit_J = c->growth_J},
    };
    past_fill(&reflexes->following.setpoints_m, config->manipulator.initial_position_m);
}

static int follow(struct following_error *following, const struct reflex_input *in)
{
    if (!(following->limit_m <= DBL_MAX)) {
        return 0;
    }
    past_add(&following->setpoints_m, in->setpoint_m);
    if (in->has_report) {
        following->error_m = in->reported_m - past_before(&following->setpoints_m, following->delay_ticks);
        const int is_beyond =
            !(following->error_m >= -following->limit_m && following->error_m <= following->limit_m);
        following->since_ns = is_beyond && following->is_beyond ? following->since_ns : in->now_ns;
        following->is_beyond = (uint8_t)is_beyond;
        following->is_on = is_beyond && in->now_ns - following->since_ns >= following->lasts_after_ns;
    }
    return following->is_on;
}

static int lacks_quality(struct link_quality *quality, const struct reflex_input *in)
{
    if (!in->is_running) {
        quality->feedback_share = quality->sensor_share = 1.0;
        return 0;
    }
    const double sample = in->has_sample ? 1.0 / quality->samples_per_tick : 0.0;
    quality->feedback_share += quality->weight * ((in->has_report ? 1.0 : 0.0) - quality->feedback_share);
    quality->sensor_share += quality->weight * (sample - quality->sensor_share);
    return quality->feedback_share < quality->least || quality->sensor_share < quality->least;
}

static int makes_power(struct dead_time_power *power, const struct reflex_input *in)
{
    const int goes_on = in->is_running && power->was_running;
    power->was_running = in->is_running != 0;
    if (!goes_on) { /* the account begins anew with each run */
        power->power_W = 0.0;
        power->made_J = in->dead_time_J;
        return 0;
    }
    power->power_W += power->weight * ((in->dead_time_J - power->made_J) / power->period_s - power->power_W);
    power->made_J = in->dead_time_J;
    return power->power_W > power->limit_W;
}

static int grows(struct growth *growth, const struct reflex_input *in)
{
    const int goes_on = in->is_running && growth->was_running;
    growth->was_running = in->is_running != 0;
    growth->begin_J = goes_on ? growth->begin_J : in->stored_J - in->operator_J;
    growth->surplus_J = in->stored_J - in->operator_J - growth->begin_J;
    return growth->surplus_J > growth->limit_J;
}

uint32_t reflexes_step(struct reflexes *reflexes, const struct reflex_input *in)
{
    return (follow(&reflexes->following, in) ? (uint32_t)REFLEX_FOLLOWING_ERROR : 0u) |
           (lacks_quality(&reflexes->quality, in) ? (uint32_t)REFLEX_LINK_QUALITY : 0u) |
           (makes_power(&reflexes->power, in) ? (uint32_t)REFLEX_DEAD_TIME_POWER : 0u) |
           (grows(&reflexes->growth, in) ? (uint32_t)REFLEX_GROWTH : 0u);
}
