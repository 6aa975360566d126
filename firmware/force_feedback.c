#include "force_feedback.h"

static double gain_of(double gain_max, double gain_per_tick, int64_t running_tick)
{
    const double gain = gain_per_tick * (double)running_tick;
    return gain_per_tick > 0.0 && gain < gain_max ? gain : gain_max;
}

static double gain_per_tick(const struct app_config *config)
{
    return config->feedback.ramp_s > 0.0 ? config_period_s(config) / config->feedback.ramp_s : 0.0;
}

void force_feedback_start(struct force_feedback *feedback, const struct app_config *config)
{
    const struct feedback_config *c = &config->feedback;
    *feedback = (struct force_feedback){
        .is_whole = c->gain == 1.0 && c->ramp_s == 0.0, .gain_max = c->gain, .gain_per_tick = gain_per_tick(config)};
}

void force_feedback_step(struct force_feedback *feedback, int is_running)
{
    feedback->ticks = is_running ? feedback->ticks + 1 : 0;
    feedback->gain = is_running ? gain_of(feedback->gain_max, feedback->gain_per_tick, feedback->ticks) : 0.0;
}

double force_feedback_gain(const struct app_config *config, int64_t running_tick)
{
    return running_tick > 0 ? gain_of(config->feedback.gain, gain_per_tick(config), running_tick) : 0.0;
}
