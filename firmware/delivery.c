#include "delivery.h"

void refusal_start(struct refusal *refusal, const struct app_config *config)
{
    *refusal = (struct refusal){.lasts_after_ns = ns_from_ms(config->robot_channel.unsent_after_ms)};
}

void refusal_step(struct refusal *refusal, uint32_t unsent_frames, uint32_t sent_frames, int64_t last_tick_ns)
{
    if (unsent_frames != refusal->unsent_frames) {
        refusal->since_ns = refusal->is_on ? refusal->since_ns : last_tick_ns;
        refusal->is_on = 1;
    } else if (sent_frames > 0) {
        refusal->is_on = 0;
    }
    refusal->unsent_frames = unsent_frames;
}

int refusal_lasts(const struct refusal *refusal, int64_t now_ns)
{
    return refusal->is_on && now_ns - refusal->since_ns > refusal->lasts_after_ns;
}

void setpoint_echo_report(struct setpoint_echo *echo, uint8_t counter)
{
    echo->reported = counter;
    echo->is_new = 1;
}

void setpoint_echo_rest(struct setpoint_echo *echo, int64_t now_ns)
{
    echo->sent_ns = now_ns;
    echo->judged = echo->reported;
    echo->is_seen = 0;
    echo->is_stale = 0;
}

void setpoint_echo_step(struct setpoint_echo *echo, struct setpoint_stamp newest, int64_t period_ns,
                        int64_t stale_after_ns)
{
    const uint8_t behind = (uint8_t)(newest.counter - echo->reported);
    if (!echo->is_new) {
        return;
    }
    if (behind < (uint8_t)(newest.counter - echo->judged)) {
        echo->sent_ns = newest.time_ns - behind * period_ns;
        echo->is_seen = 1;
    }
    echo->judged = echo->reported;
    echo->is_new = 0;
    echo->is_stale = newest.time_ns - echo->sent_ns > stale_after_ns;
}
