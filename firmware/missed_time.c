#include "missed_time.h"

void missed_time_start(struct missed_time *missed, const struct app_config *config)
{
    const int64_t period_ns = config_period_ns(config);
    const double share = config->loop.missed_time_budget_ms / (1e3 * config->loop.missed_time_refill_s);
    *missed = (struct missed_time){.period_ns = period_ns,
                                   .budget_ns = ns_from_ms(config->loop.missed_time_budget_ms),
                                   .refill_ns_per_tick = (int64_t)((double)period_ns * share + 0.5)};
}

void missed_time_step(struct missed_time *missed, uint32_t missed_ticks)
{
    const int64_t left_ns =
        missed->used_ns > missed->refill_ns_per_tick ? missed->used_ns - missed->refill_ns_per_tick : 0;
    const int64_t most_ns = missed->budget_ns + missed->period_ns; /* what is beyond the budget is not paid back */
    const int64_t used_ns = left_ns + (int64_t)missed_ticks * missed->period_ns;
    missed->used_ns = used_ns < most_ns ? used_ns : most_ns;
}

int missed_time_is_over(const struct missed_time *missed)
{
    return missed->used_ns > missed->budget_ns;
}
