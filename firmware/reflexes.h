/* What a loop notices of itself: a robot that is not where its setpoints led it, frames that come too rarely, and
 * energy that dead time makes, and motion that grows by itself. Each has its own condition for the supervisor. */
#ifndef FIRMWARE_REFLEXES_H
#define FIRMWARE_REFLEXES_H

#include "config.h"
#include "past.h"
#include "supervisor.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where the robot reports to be, against the setpoint that it should have reached when it reported. */
struct following_error {
    double limit_m;
    int64_t lasts_after_ns;
    double delay_ticks; /* from a setpoint, sent in the last tick, to the report that tells of it */
    struct past setpoints_m;
    double error_m;   /* at the newest report */
    int64_t since_ns; /* the first report in the row that was beyond the limit */
    uint8_t is_beyond;
    uint8_t is_on; /* beyond for long enough */
};

/* Share of the ticks that brought a report of the robot and a force sample, the smaller of both, over a window: it
 * forgets exponentially. */
struct link_quality {
    double least;
    double weight;         /* of one tick */
    double feedback_share; /* of ticks with a report */
    double sensor_share;   /* of ticks with a sample, of those that a sensor of this rate can bring one in */
    double samples_per_tick;
};

/* Power that dead time makes, over a window as above. */
struct dead_time_power {
    double limit_W;
    double weight; /* of one tick */
    double period_s;
    uint8_t was_running;
    double made_J; /* up to the last tick */
    double power_W;
};

/* Energy that the manipulator has and nobody gave it: a loop that diverges gains it, a stable one gets at most what
 * its object had stored. */
struct growth {
    double limit_J;
    uint8_t was_running;
    double begin_J;
    double surplus_J;
};

struct reflexes {
    struct following_error following;
    struct link_quality quality;
    struct dead_time_power power;
    struct growth growth;
};

struct reflex_input {
    int64_t now_ns;
    double setpoint_m; /* sent in the last tick */
    double reported_m; /* by the robot */
    int has_report;    /* in this tick */
    int has_sample;
    int is_running;
    double dead_time_J; /* made by dead time, since the loop last began to run */
    double stored_J;    /* in the manipulator, now */
    double operator_J;  /* given to it by the operator since then */
};

/* Conditions that go to the supervisor. */
enum reflex {
    REFLEX_FOLLOWING_ERROR = CONDITION_FOLLOWING_ERROR,
    REFLEX_LINK_QUALITY = CONDITION_LINK_QUALITY,
    REFLEX_DEAD_TIME_POWER = CONDITION_DEAD_TIME_POWER,
    REFLEX_GROWTH = CONDITION_GROWTH,
};

void reflexes_start(struct reflexes *reflexes, const struct app_config *config);

/* One tick. Returns the set of enum reflex that act. */
uint32_t reflexes_step(struct reflexes *reflexes, const struct reflex_input *in);

/* Ticks from a setpoint to the report that tells of it, less one: the newest setpoint is that of the last tick. */
double following_delay_ticks(const struct app_config *config);

#ifdef __cplusplus
}
#endif
#endif
