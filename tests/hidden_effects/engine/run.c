/* Tick by tick: sample, send, step the manipulator, let the hardware move on. */
#include <stdlib.h>
#include <string.h>

#include "plant.h"

struct inputs {
    int64_t ticks;               /* settling included; so are all arrays */
    const double *operator_N;    /* acts from t_n on */
    const double *force_noise_N; /* of the sample that tick n uses, spikes included */
    const double *robot_noise_m;
    const double *command_noise_m;
    const uint8_t *command_is_lost;
    const uint8_t *force_is_lost; /* the sample before stands */
    const uint8_t *tick_is_lost;  /* force and robot position stand */
    const double *command_m;      /* given setpoints: the loop is open; NULL: closed */
    const double *exact_step;     /* of the firmware's manipulator: rows x, v; columns x, v, net force */
    double start_m;               /* where everything rests before the first tick */
};

struct outputs {
    double *command_m, *robot_m, *force_N; /* as recorded */
    double *clean_robot_m, *clean_force_N; /* before measurement noise and resolution */
    double *object_m, *spring_N;           /* at the ticks */
};

struct manipulator {
    double x, v, friction;
    int direction;
};

static double manipulator_force_N(const struct truth *p, const struct manipulator *start, double x, double v,
                                  double net_N)
{
    const int d = start->direction;
    const double D = p->manipulator_damping_N_s_per_m + d * p->manipulator_damping_asymmetry_N_s_per_m;
    const double friction = dahl(start->friction, x - start->x, p->manipulator_presliding_m, d);
    const double slow = v / p->manipulator_stribeck_m_per_s;
    const double level = (friction >= 0.0 ? p->manipulator_friction_up_N : p->manipulator_friction_down_N) +
                         p->manipulator_stribeck_N * exp(-slow * slow);
    return net_N - D * v - p->manipulator_stiffness_N_per_m * dead_zone(x, 0.5 * p->manipulator_gap_m) -
           p->manipulator_cubic_N_per_m3 * x * x * x - p->manipulator_quadratic_N_per_m2 * x * x -
           p->manipulator_gravity_N - level * friction;
}

static void step_manipulator(const struct truth *p, struct manipulator *m, double net_N, double h)
{
    double kx[4], kv[4];
    for (int i = 0; i < 4; i++) {
        const double c = i == 0 ? 0.0 : i == 3 ? h : 0.5 * h;
        const double v = m->v + (i ? c * kv[i - 1] : 0.0);
        const double x = m->x + (i ? c * kx[i - 1] : 0.0);
        kx[i] = v;
        kv[i] = manipulator_force_N(p, m, x, v, net_N) / p->manipulator_mass_kg;
    }
    const double x = m->x + h / 6.0 * (kx[0] + 2.0 * kx[1] + 2.0 * kx[2] + kx[3]);
    m->friction = dahl(m->friction, x - m->x, p->manipulator_presliding_m, m->direction);
    m->x = x;
    m->v += h / 6.0 * (kv[0] + 2.0 * kv[1] + 2.0 * kv[2] + kv[3]);
}

/* The measured manipulator over one period, cut where it turns round or enters and leaves the gap. */
static void move_manipulator(const struct truth *p, struct manipulator *m, double net_N)
{
    double left_s = p->period_s;
    int cuts_left = 100;
    while (left_s > 1e-12) {
        const double h = left_s / ceil(left_s / p->substep_s - 1e-6);
        const struct manipulator start = *m;
        const double half = 0.5 * p->manipulator_gap_m;
        const int side = (start.x > half) - (start.x < -half);
        double low = 0.0, high = h, taken = h;
        step_manipulator(p, m, net_N, h);
#define SWITCHED (sign_of(m->v, start.direction) != start.direction || (m->x > half) - (m->x < -half) != side)
        if (SWITCHED && cuts_left-- > 0) {
            while (high - low > 1e-10) {
                taken = 0.5 * (low + high);
                *m = start;
                step_manipulator(p, m, net_N, taken);
                if (SWITCHED) {
                    high = taken;
                } else {
                    low = taken;
                }
            }
            *m = start;
            taken = high;
            step_manipulator(p, m, net_N, taken);
        }
#undef SWITCHED
        m->direction = sign_of(m->v, start.direction);
        left_s -= taken;
    }
}

static void move_firmware(const double *step, struct manipulator *m, double net_N)
{
    const double x = step[0] * m->x + step[1] * m->v + step[2] * net_N;
    m->v = step[3] * m->x + step[4] * m->v + step[5] * net_N;
    m->x = x;
}

/* The setpoint that the robot stands on after tick n: `sent`, or the last one if it is lost or too near. */
static double heard(const struct truth *p, double sent, double standing, int is_lost)
{
    return is_lost || fabs(sent - standing) < p->robot_deadband_m ? standing : sent;
}

static void add_knot(struct loop *l, double now_s, double end_s, double length_s, double position_m)
{
    if (l->p->robot_acceleration_limit_m_per_s2 < 1e8) {
        position_m = limit_acceleration(l->p, &l->memory, position_m);
    }
    const int64_t last = l->first + l->count - 1;
    double begin_s = fmax(end_s - length_s, now_s);
    if (l->count > 0) {
        begin_s = fmax(begin_s, l->knots[last].end_s);
    }
    l->knots[last + 1] = (struct knot){begin_s, fmax(end_s, begin_s + 1e-9), position_m};
    l->count++;
}

/* Hardware from t_n to t_(n+1), and the sensor's sample on the way, `sample_after_s` after the tick. */
static double move_hardware(struct loop *l, double end_s, double sample_s)
{
    double sample_N = sensed_N(l);
    while (l->t < end_s - 1e-12) {
        while (l->count > 0 && l->knots[l->first].end_s <= l->t + 1e-12) {
            l->passed_m = l->knots[l->first].position_m;
            l->first++;
            l->count--;
        }
        double until_s = end_s;
        if (l->count > 0) {
            const struct knot *k = &l->knots[l->first];
            until_s = fmin(until_s, k->begin_s > l->t + 1e-12 ? k->begin_s : k->end_s);
        }
        if (sample_s > l->t + 1e-12) {
            until_s = fmin(until_s, sample_s);
        }
        advance_hardware(l, until_s);
        if (fabs(l->t - sample_s) < 1e-12) {
            sample_N = sensed_N(l);
        }
    }
    return sample_N;
}

static double read_N(const struct truth *p, double sensed, double operator_N, double t, double noise_N)
{
    const double F = sensed * (1.0 + p->sensor_curvature_per_N * fabs(sensed));
    const double read =
        p->sensor_gain * F + p->sensor_even_per_N * F * F + p->sensor_bias_N +
        p->sensor_drift_N_per_s * since_start(t) + p->sensor_crosstalk * operator_N +
        p->sensor_warming_N * (1.0 - exp(-since_start(t) / p->sensor_warming_s)) +
        p->sensor_periodic_N * sin(p->sensor_periodic_rad_per_s * (t - p->sensor_delay_s) + p->sensor_periodic_rad) +
        noise_N; /* it hums into the sample, which is read a delay later */
    return rounded(clamp(read, -p->sensor_saturation_N, p->sensor_saturation_N), p->sensor_step_N);
}

static void rest(struct loop *l, const struct truth *p, double at_m)
{
    const double u = p->robot_gain * at_m;
    const double r = with_periodic_error(p, u);
    const double k = p->contact > 0.0 ? 0.0 : p->object_stiffness_N_per_m;
    const double x = r * p->spring_stiffness_N_per_m / (p->spring_stiffness_N_per_m + k);
    l->p = p;
    l->passed_m = at_m;
    l->memory = (struct memory){.goal_m = at_m,
                                .profiled_m = at_m,
                                .reference_m = u,
                                .limited_m = u,
                                .lagged_m = u,
                                .resonant_m = u,
                                .play_m = u,
                                .robot_m = r};
    l->state[X] = l->state[X2] = x;
    l->state[Y] = l->state[Y_LAG] = p->spring_stiffness_N_per_m * (r - x);
}

/* The robot's own clock: at each of its instants up to now it takes the newest setpoint, if there is a new one. */
struct robot_clock {
    int64_t count;
    int is_new;
    double setpoint_m;
};

static void latch(struct loop *l, struct robot_clock *clock, double until_s)
{
    const struct truth *p = l->p;
    const double period_s = p->period_s * (1.0 + p->clock_drift), dead_s = p->robot_dead_time_s;
    const double origin_s = p->clock_phase_s - p->settle_ticks * period_s;
    for (;;) {
        const double now_s = origin_s + (double)clock->count * period_s;
        if (now_s >= until_s) {
            return;
        }
        if (clock->is_new) {
            add_knot(l, now_s, now_s + dead_s, period_s, clock->setpoint_m);
            clock->is_new = 0;
        }
        clock->count++;
    }
}

int run(const struct truth *p, const struct inputs *in, const struct outputs *out)
{
    const double T = p->period_s;
    struct loop l;
    memset(&l, 0, sizeof l);
    l.knots = malloc(((size_t)in->ticks + 2) * 2 * sizeof *l.knots);
    double *samples = malloc(((size_t)in->ticks + 1) * sizeof *samples);
    if (!l.knots || !samples) {
        return 1;
    }
    rest(&l, p, in->start_m);
    struct manipulator manipulator = {.x = in->start_m};
    struct robot_clock clock = {0, 0, 0.0};
    double standing_m = in->start_m;
    const double rest_N = sensed_N(&l);
    const double tiny = 1e-6; /* of a tick: no step of the integration is as short */
    const int64_t whole = (int64_t)floor(p->sensor_delay_s / T + tiny);
    double early_s = p->sensor_delay_s - (double)whole * T; /* the sample is that much before a tick */
    early_s = early_s < tiny * T ? 0.0 : early_s;
    l.t = -p->settle_ticks * T;

    for (int64_t n = 0; n < in->ticks; n++) {
        const double t = ((double)n - p->settle_ticks) * T;
        const int64_t used = early_s > 0.0 ? n - whole - 1 : n - whole;
        if (early_s == 0.0) {
            samples[n] = sensed_N(&l);
        }
        const double sensed = used >= 0 ? samples[used] : rest_N;
        out->clean_robot_m[n] = l.memory.robot_m;
        out->clean_force_N[n] = sensed;
        out->object_m[n] = l.state[X];
        out->spring_N[n] = spring_now_N(&l);
        out->robot_m[n] = rounded(l.memory.robot_m + in->robot_noise_m[n], p->robot_step_m);
        out->force_N[n] = n > 0 && in->force_is_lost[n]
                              ? out->force_N[n - 1]
                              : read_N(p, sensed, in->operator_N[n], t, in->force_noise_N[n]);
        if (n > 0 && in->tick_is_lost[n]) {
            out->robot_m[n] = out->robot_m[n - 1];
            out->force_N[n] = out->force_N[n - 1];
        }
        const double wanted_m = in->command_m ? in->command_m[n] : manipulator.x + in->command_noise_m[n];
        out->command_m[n] = rounded(wanted_m, p->command_step_m);
        standing_m = heard(p, out->command_m[n], standing_m, in->command_is_lost[n]);
        if (p->free_clock > 0.0) {
            clock.setpoint_m = standing_m;
            clock.is_new = 1;
            latch(&l, &clock, t + T);
        } else {
            add_knot(&l, t, t + p->robot_dead_time_s + p->robot_dead_time_drift * since_start(t), T, standing_m);
        }
        const double net_N = in->operator_N[n] - out->force_N[n];
        if (p->manipulator_is_measured > 0.0) {
            move_manipulator(p, &manipulator, net_N);
        } else {
            move_firmware(in->exact_step, &manipulator, net_N);
        }
        if (!in->command_m && (!isfinite(manipulator.x) || fabs(manipulator.x) > 10.0)) {
            free(l.knots);
            free(samples);
            return 2; /* unstable */
        }
        const double sample = move_hardware(&l, t + T, early_s > 0.0 ? t + T - early_s : t);
        if (early_s > 0.0) {
            samples[n] = sample;
        }
    }
    free(l.knots);
    free(samples);
    return 0;
}

/* Recorded operator and force to the manipulator's position alone. */
void replay_manipulator(const struct truth *p, int64_t ticks, const double *net_N, const double *exact_step,
                        const double *start, double *position_m)
{
    struct manipulator m = {.x = start[0], .v = start[1]};
    for (int64_t n = 0; n < ticks; n++) {
        position_m[n] = m.x;
        if (p->manipulator_is_measured > 0.0) {
            move_manipulator(p, &m, net_N[n]);
        } else {
            move_firmware(exact_step, &m, net_N[n]);
        }
    }
}
