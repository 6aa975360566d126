/* Sensor spring, object and low-pass, and the steps of the integration. */
#include <string.h>

#include "plant.h"

static double spring_N(const struct truth *p, const double *s, double r, double r_rate)
{
    return p->spring_stiffness_N_per_m * (r - s[X]) + p->spring_damping_N_s_per_m * (r_rate - s[V]);
}

static double contact_N(const struct truth *p, const double *s)
{
    const double depth_m = s[X] - p->surface_m;
    if (p->impact_damping_s_per_m > 0.0) {
        return p->object_stiffness_N_per_m * depth_m * (1.0 + p->impact_damping_s_per_m * s[V]);
    }
    return p->object_stiffness_N_per_m * depth_m + p->object_damping_N_s_per_m * s[V];
}

/* What the object resists with, friction apart. */
static double resistance_N(const struct truth *p, const struct modes *mode, const double *s, double t)
{
    if (p->contact > 0.0) {
        return mode->touches ? contact_N(p, s) : 0.0;
    }
    const double x = s[X], v = s[V],
                 k = p->object_stiffness_N_per_m * (1.0 + p->object_drift_per_s * since_start(t));
    double stretched_m = x;
    if (p->object_gap_m > 0.0) {
        stretched_m = mode->gap_side ? x - 0.5 * mode->gap_side * p->object_gap_m : 0.0;
    } else if (p->object_softening_m > 0.0) {
        stretched_m = p->object_softening_m * sin(x / p->object_softening_m);
    }
    return k * stretched_m + p->object_damping_N_s_per_m * v + p->object_cubic_N_per_m3 * x * x * x +
           p->object_quadratic_N_per_m2 * x * x + p->object_drag_N_s2_per_m2 * v * fabs(v);
}

static double friction_N(const struct truth *p, const struct memory *m, int direction, const double *s, double way_m)
{
    double force_N = 0.0;
    if (p->object_friction_N > 0.0) {
        const double ratio = s[V] / p->object_stribeck_m_per_s;
        const double level = 1.0 + (p->object_static_ratio - 1.0) * exp(-ratio * ratio);
        force_N += p->object_friction_N * level * dahl(m->friction, way_m, p->object_presliding_m, direction);
    }
    if (p->object_hysteresis_N > 0.0) {
        const double z = p->object_hysteresis_exponent > 0.0
                             ? s[Z_WEN]
                             : dahl(m->dahl, way_m, p->object_hysteresis_length_m, direction);
        force_N += p->object_hysteresis_N * z;
    }
    return force_N;
}

struct line {
    double r, r_rate; /* of the robot, r at the start of the step */
};

static void rates(const struct loop *l, const struct line *line, double x_start, const double *s, double after,
                  double *rate)
{
    const struct truth *p = l->p;
    const struct modes *mode = &l->modes;
    const double r = line->r + line->r_rate * after;
    const double F = mode->is_loose ? 0.0 : spring_N(p, s, r, line->r_rate);
    double net_N =
        F - resistance_N(p, mode, s, l->t + after) - friction_N(p, &l->memory, mode->direction, s, s[X] - x_start);
    memset(rate, 0, STATES * sizeof *rate);
    if (p->second_mass_kg > 0.0) {
        const double hang_N =
            p->second_stiffness_N_per_m * (s[X2] - s[X]) + p->second_damping_N_s_per_m * (s[V2] - s[V]);
        net_N += hang_N;
        rate[X2] = s[V2];
        rate[V2] = -hang_N / p->second_mass_kg;
    }
    if (p->relaxation_N_per_m > 0.0) {
        net_N -= s[Z_RELAX];
        rate[Z_RELAX] = p->relaxation_N_per_m * s[V] - s[Z_RELAX] / p->relaxation_s;
    }
    rate[X] = s[V];
    rate[V] = net_N / p->object_mass_kg;
    if (p->object_hysteresis_exponent > 0.0) {
        const double z = s[Z_WEN], same = s[V] * z > 0.0 ? 1.0 : 0.0;
        rate[Z_WEN] =
            s[V] / p->object_hysteresis_length_m * (1.0 - pow(fabs(z), p->object_hysteresis_exponent) * same);
    }
    const double w = p->low_pass_rad_per_s;
    double y = F;
    if (p->low_pass_order > 1.5) {
        rate[Y] = s[Y_RATE];
        rate[Y_RATE] = w * w * (F - s[Y]) - 2.0 * p->low_pass_damping * w * s[Y_RATE];
        y = s[Y];
    } else if (p->low_pass_order > 0.5) {
        rate[Y] = w * (F - s[Y]);
        y = s[Y];
    }
    if (p->sensor_lag_s > 0.0) {
        rate[Y_LAG] = (y - s[Y_LAG]) / p->sensor_lag_s;
    }
}

/* The modes that fit where the loop now is. */
static struct modes modes_after(const struct loop *l, const struct modes *held, double r_rate)
{
    const struct truth *p = l->p;
    struct modes next = *held; /* the robot's are known already */
    const double *s = l->state;
    if (p->object_friction_N > 0.0 || p->object_hysteresis_N > 0.0) {
        next.direction = sign_of(s[V], held->direction);
    }
    if (p->contact > 0.0) {
        next.touches = s[X] > p->surface_m && contact_N(p, s) > 0.0;
    }
    if (p->object_gap_m > 0.0) {
        next.gap_side = dead_zone(s[X], 0.5 * p->object_gap_m) > 0.0   ? 1
                        : dead_zone(s[X], 0.5 * p->object_gap_m) < 0.0 ? -1
                                                                       : 0;
    }
    if (p->grip_N < 1e11) {
        /* Touched again it holds, if it need not pull too much at once. */
        const int is_apart = held->is_loose && s[X] > l->memory.robot_m;
        next.is_loose = is_apart || spring_N(p, s, l->memory.robot_m, r_rate) < -p->grip_N;
    }
    return next;
}

/* One step of length h with the modes held; the modes that fit its end come back. */
static struct modes step(struct loop *l, double h)
{
    const struct truth *p = l->p;
    struct memory m = l->memory;
    struct modes held = l->modes;
    move_robot(l, &m, &held, h);
    const struct line line = {l->memory.robot_m, (m.robot_m - l->memory.robot_m) / h};
    if (p->grip_N < 1e11 && !held.is_loose && spring_N(p, l->state, line.r, line.r_rate) < -p->grip_N) {
        held.is_loose = l->modes.is_loose = 1; /* at a corner of the robot's way the damper's force jumps */
    }
    /* The tool's velocity jumps with the robot's: an impulse on the low-pass. */
    l->state[Y_RATE] +=
        p->low_pass_rad_per_s * p->low_pass_rad_per_s * p->tool_mass_kg * (line.r_rate - l->robot_m_per_s);
    const double x_start = l->state[X];
    double k[4][STATES], s[STATES];
    rates(l, &line, x_start, l->state, 0.0, k[0]);
    for (int i = 1; i < 4; i++) {
        const double c = i == 3 ? h : 0.5 * h;
        for (int j = 0; j < STATES; j++) {
            s[j] = l->state[j] + c * k[i - 1][j];
        }
        rates(l, &line, x_start, s, c, k[i]);
    }
    for (int j = 0; j < STATES; j++) {
        l->state[j] += h / 6.0 * (k[0][j] + 2.0 * k[1][j] + 2.0 * k[2][j] + k[3][j]);
    }
    const double way_m = l->state[X] - x_start;
    m.friction = dahl(m.friction, way_m, p->object_presliding_m, l->modes.direction);
    m.dahl = dahl(m.dahl, way_m, p->object_hysteresis_length_m, l->modes.direction);
    l->memory = m;
    l->robot_m_per_s = line.r_rate;
    l->t += h;
    return modes_after(l, &held, line.r_rate);
}

static int same(const struct modes *a, const struct modes *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

double spring_now_N(const struct loop *l)
{
    return l->modes.is_loose ? 0.0 : spring_N(l->p, l->state, l->memory.robot_m, l->robot_m_per_s);
}

double sensed_N(const struct loop *l)
{
    if (l->p->sensor_lag_s > 0.0) {
        return l->state[Y_LAG];
    }
    return l->p->low_pass_order > 0.5 ? l->state[Y] : spring_now_N(l);
}

void advance_hardware(struct loop *l, double until_s)
{
    int cuts_left = 400; /* a switch that chatters is not followed for ever */
    while (l->t < until_s - 1e-12) {
        const double left_s = until_s - l->t;
        const double h = left_s / ceil(left_s / l->p->substep_s - 1e-6);
        const struct loop start = *l;
        struct modes next = step(l, h);
        if (!same(&next, &start.modes) && cuts_left-- > 0) {
            double low = 0.0, high = h;
            while (high - low > 1e-10) {
                const double middle = 0.5 * (low + high);
                *l = start;
                next = step(l, middle);
                if (same(&next, &start.modes)) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            *l = start;
            next = step(l, high);
        }
        l->modes = next;
    }
    l->t = until_s;
}
