/* Motion side: the setpoint that the manipulator will want when the robot gets there, on a polynomial through its
 * positions now and whole delays ago (Horiuchi et al. 1999):
 *     x(t + d) = sum over i = 0..n of (-1)^i C(n + 1, i + 1) x(t - i d)
 * Price: noise is amplified, and so is motion that is fast compared with the delay; n = 3 turns a spring's damping
 * negative from w d = pi/2 on, n = 2 from pi/3 on. */
#ifndef FIRMWARE_COMPENSATION_EXTRAPOLATION_H
#define FIRMWARE_COMPENSATION_EXTRAPOLATION_H

#include "../config.h"
#include "../past.h"

#ifdef __cplusplus
extern "C" {
#endif

#define EXTRAPOLATION_ORDER_MAX 3

struct extrapolation {
    uint32_t order;
    double delay_ticks;
    struct past past_m;
};

/* Enough ticks are kept for the order and the delay. */
int extrapolation_fits(const struct app_config *config);

/* Starts at rest at the manipulator's initial position. */
void extrapolation_start(struct extrapolation *extrapolation, const struct app_config *config);

/* Forgets the past: as if the position had always been `position_m`. */
void extrapolation_rest_at(struct extrapolation *extrapolation, double position_m);

/* One tick: position of the manipulator in, setpoint out, in m. Passes through if the order is 0. */
double extrapolation_step(struct extrapolation *extrapolation, double position_m);

#ifdef __cplusplus
}
#endif
#endif
