#include "limits.h"

#include <float.h>

const char *const limit_names[LIMIT_COUNT] = {"not_finite", "position", "velocity", "acceleration"};

/* Below this the setpoints count as standing still: a tenth of a micrometre a tick at 400 Hz. */
#define REST_VELOCITY_m_per_s 4e-5
#define REST_DISTANCE_m 1e-6

static double magnitude(double value)
{
    return value < 0.0 ? -value : value;
}

static double clamp(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

/* The largest speed for the coming tick from which the setpoints can stop within `distance_m` at the acceleration
 * limit. With a change of aT a tick, k ticks of braking follow where k (k+1) / 2 <= d/(aT^2), and
 * v = aT (k/2 + d/(aT^2) / (k+1)) uses up the distance exactly. */
static double stopping_speed(const struct limits *limits, double distance_m)
{
    if (distance_m <= 0.0) {
        return 0.0;
    }
    const double change = limits->config->acceleration_m_per_s2 * limits->period_s;
    const double ratio = distance_m / (change * limits->period_s);
    const double root = 0.5 * (__builtin_sqrt(1.0 + 8.0 * ratio) - 1.0);
    const double ticks = root < 1e9 ? (double)(int64_t)root : root;
    return change * (0.5 * ticks + ratio / (ticks + 1.0));
}

/* The setpoints are where they were asked to be, or so near that one tick's acceleration closes the gap. */
static int on_target(const struct limits *limits)
{
    const double gap_m = magnitude(limits->target_m - limits->position_m);
    return gap_m <= limits->config->acceleration_m_per_s2 * limits->period_s * limits->period_s;
}

/* The velocity that leads to the wanted position at the next tick; where the setpoints have fallen behind, the
 * target's own velocity and no more on top than can be braked away. */
static double wished_velocity(const struct limits *limits, double wanted_m, int is_on_target)
{
    if (is_on_target) {
        return (wanted_m - limits->position_m) / limits->period_s;
    }
    const double gap_m = limits->target_m - limits->position_m;
    const double closing_speed = stopping_speed(limits, magnitude(gap_m));
    const double target_velocity = (wanted_m - limits->target_m) / limits->period_s;
    return target_velocity + (gap_m < 0.0 ? -closing_speed : closing_speed);
}

void limits_start_at(struct limits *limits, const struct limits_config *config, double period_s, double position_m)
{
    *limits =
        (struct limits){.config = config, .period_s = period_s, .target_m = position_m, .position_m = position_m};
}

void limits_start(struct limits *limits, const struct app_config *config)
{
    limits_start_at(limits, &config->limits, config_period_s(config), config->manipulator.initial_position_m);
}

static void count_active(struct limits *limits)
{
    for (int i = 0; limits->active >> i; i++) {
        limits->active_ticks[i] += (limits->active >> i) & 1u;
    }
}

static double limited(struct limits *limits, enum limit limit, double value, double low, double high)
{
    const double result = clamp(value, low, high);
    if (result != value) {
        limits->active |= (uint32_t)limit;
    }
    return result;
}

double limits_step(struct limits *limits, double wanted_m)
{
    const struct limits_config *config = limits->config;
    limits->active = 0;
    if (!(wanted_m >= -DBL_MAX && wanted_m <= DBL_MAX)) {
        limits->active |= LIMIT_NOT_FINITE;
        wanted_m = limits->target_m;
    }
    const double target_m =
        limited(limits, LIMIT_POSITION, wanted_m, config->position_min_m, config->position_max_m);
    const int is_on_target = on_target(limits);
    const double wished = wished_velocity(limits, target_m, is_on_target);

    double velocity = limited(limits, LIMIT_VELOCITY, wished, -config->velocity_m_per_s, config->velocity_m_per_s);
    const double room_m =
        velocity < 0.0 ? limits->position_m - config->position_min_m : config->position_max_m - limits->position_m;
    const double stoppable = stopping_speed(limits, room_m);
    velocity = limited(limits, LIMIT_POSITION, velocity, -stoppable, stoppable);
    const double change = config->acceleration_m_per_s2 * limits->period_s;
    velocity = limited(limits, LIMIT_ACCELERATION, velocity, limits->velocity_m_per_s - change,
                       limits->velocity_m_per_s + change);

    const double moved_m =
        velocity == wished && is_on_target ? target_m : limits->position_m + velocity * limits->period_s;
    const double position_m =
        limited(limits, LIMIT_POSITION, moved_m, config->position_min_m, config->position_max_m);
    limits->target_m = target_m;
    limits->velocity_m_per_s = (position_m - limits->position_m) / limits->period_s;
    limits->position_m = position_m;
    count_active(limits);
    return position_m;
}

double limits_stop(struct limits *limits)
{
    const struct limits_config *config = limits->config;
    const double change = config->acceleration_m_per_s2 * limits->period_s;
    const double speed = magnitude(limits->velocity_m_per_s);
    const double ticks = (double)(int64_t)(speed / change); /* with motion left; in the one after it, it rests */
    const double way_m = ticks * (speed - 0.5 * change * (ticks + 1.0)) * limits->period_s;
    limits->target_m = clamp(limits->position_m + (limits->velocity_m_per_s < 0.0 ? -way_m : way_m),
                             config->position_min_m, config->position_max_m);
    return limits->target_m;
}

int limits_at_rest(const struct limits *limits)
{
    return magnitude(limits->velocity_m_per_s) < REST_VELOCITY_m_per_s &&
           magnitude(limits->target_m - limits->position_m) < REST_DISTANCE_m;
}
