/* The loop with its effects, for the generator of hidden effects only: written from the definitions, on its own.
 *
 * Everything between two events is smooth and is integrated by Runge and Kutta's fourth-order rule in short steps.
 * What switches is a mode: it is held during a step, and a step that would end in another mode is cut at the switch.
 */
#ifndef HIDDEN_EFFECTS_PLANT_H
#define HIDDEN_EFFECTS_PLANT_H

#include <math.h>
#include <stdint.h>

#include "truth.h"

enum { X, V, Y, Y_RATE, Y_LAG, X2, V2, Z_WEN, Z_RELAX, STATES };

/* What rate-independent parts remember, and where the robot is. */
struct memory {
    double reference_m;           /* after the dead time */
    double limited_m, windup_m_s; /* of the velocity limit */
    /* Of the acceleration limit; the goal is the last setpoint that it was given. */
    double goal_m, profiled_m, profiled_m_per_s, profiled_windup_m_s;
    double lagged_m;
    double resonant_m, resonant_m_per_s;
    double play_m;
    double hysteresis;     /* of the robot, -1..1 */
    double robot_m;        /* r */
    double friction, dahl; /* of the object, -1..1 */
};

struct modes {
    int limiter, play, direction, touches, gap_side, is_loose;
};

struct knot {
    double begin_s, end_s, position_m;
};

struct loop {
    const struct truth *p;
    double t;
    double state[STATES];
    double robot_m_per_s;
    struct memory memory;
    struct modes modes;
    struct knot *knots;
    int64_t first, count; /* of the knots not yet passed */
    double passed_m;      /* the last one passed */
};

/* The robot over a step; its memory and its modes come out. */
void move_robot(const struct loop *l, struct memory *m, struct modes *modes, double h);

/* A setpoint to what the robot's acceleration permits. */
double limit_acceleration(const struct truth *p, struct memory *m, double goal_m);

double with_periodic_error(const struct truth *p, double r);

/* Where the reference line is, before gain and limits. */
double reference_at(const struct loop *l, double t);

/* What the sensor would sample now, before gain, bias and the like. */
double sensed_N(const struct loop *l);

/* F now, before the low-pass. */
double spring_now_N(const struct loop *l);

/* A stretch without kinks of the reference: short steps, cut where a mode changes. */
void advance_hardware(struct loop *l, double until_s);

static inline double clamp(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

static inline double rounded(double value, double step)
{
    return step > 0.0 ? step * rint(value / step) : value;
}

static inline double since_start(double t)
{
    return t > 0.0 ? t : 0.0;
}

static inline double dead_zone(double x, double half)
{
    return x > half ? x - half : x < -half ? x + half : 0.0;
}

/* A sign that keeps its last value where the velocity is nothing but rounding. */
static inline int sign_of(double velocity, int last)
{
    return velocity > 1e-13 ? 1 : velocity < -1e-13 ? -1 : last;
}

/* Dahl's z after a way: exact for any velocity as long as the direction stays. */
static inline double dahl(double z, double way_m, double length_m, int direction)
{
    return direction == 0 ? z : direction + (z - direction) * exp(-fabs(way_m) / length_m);
}

#endif
