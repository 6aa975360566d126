/* The hardware as the loop knows it, run along with the real one on the setpoints that go out: what the force sensor
 * would show of it. Exact between setpoints; a tool in contact looks whether it touches at every substep.
 *
 *   robot           p'' = w^2 (u - p) - 2 z w p'     (or p = u);  its lag  t r' = p - r  (or r = p); u: with its
 * gain sensor spring   F = k_S (r - x) + d_S (r' - x') object          m x'' = F - d x' - k x           (a tool: the
 * last two only where it touches and does not pull) low-pass        y'' = w_L^2 (F - y) - 2 z_L w_L y'  (order 2; y'
 * = w_L (F - y), or y = F);  t_S s' = y - s
 */
#ifndef FIRMWARE_COMPENSATION_HARDWARE_TWIN_H
#define FIRMWARE_COMPENSATION_HARDWARE_TWIN_H

#include "../config.h"
#include "../past.h"

#ifdef __cplusplus
extern "C" {
#endif

enum twin_state {
    TWIN_OBJECT_POSITION, /* x, m; all positions count from the surface */
    TWIN_OBJECT_VELOCITY,
    TWIN_LOW_PASS, /* y, N */
    TWIN_LOW_PASS_RATE,
    TWIN_ROBOT_POSITION, /* p, m */
    TWIN_ROBOT_VELOCITY,
    TWIN_ROBOT_LAG,  /* r, m */
    TWIN_SENSOR_LAG, /* s, N */
    TWIN_STATES
};
#define TWIN_INPUTS 2 /* u and u' at the begin of a substep */
#define TWIN_SUBSTEPS_MAX 16

/* Over one substep, row-major, [free or touching]. */
struct twin_transition {
    double of[2][TWIN_STATES][TWIN_STATES + TWIN_INPUTS];
};

/* A tick by its setpoints: from one to the next, cut where the sample is taken. */
struct hardware_twin {
    struct hardware_model model;
    double period_s;
    double state[TWIN_STATES];
    double output[TWIN_STATES + TWIN_INPUTS]; /* the sample as a row of state and input */
    double jump[TWIN_STATES];                 /* by which a jump of 1 m of the robot changes the state ("hold") */
    struct twin_transition until_sample;      /* one substep of this part of a tick */
    struct twin_transition after_sample;
    double substep_s[2];
    uint32_t substeps[2]; /* in each part */
    double position_m;    /* the last two setpoints, newest first */
    double before_m;
    uint32_t delay_ticks; /* whole ticks until a sample arrives */
    struct past samples_N;
};

/* The dead time fits. */
int hardware_twin_fits(const struct hardware_model *model, double period_s);

void hardware_twin_start(struct hardware_twin *twin, const struct hardware_model *model, double period_s,
                         double position_m);

/* One tick: the setpoint that goes out. */
void hardware_twin_step(struct hardware_twin *twin, double setpoint_m);

/* The force sample that arrives in this tick, in N, were the dead time longer by so many ticks; between ticks on
 * straight lines. */
double hardware_twin_sample(const struct hardware_twin *twin, double longer_ticks);

/* Where the robot would be without dead time, from the surface, in m. */
double hardware_twin_robot_m(const struct hardware_twin *twin);

/* The tool touches, or the object is gripped; positions count from the surface. */
int hardware_touches(const struct hardware_model *model, double depth_m, double velocity_m_per_s);

#ifdef __cplusplus
}
#endif
#endif
