/* Force side, last: no more energy comes back from the hardware than it may give. A time-domain passivity observer
 * with the mends that practice asked for, and one of two controllers (Hannaford and Ryu 2002; energy tank after
 * Franchi et al. 2011).
 *
 *     deficit(n) = reference(n) - given(n)          J that the manipulator has got out of nothing
 *
 * given: what the manipulator gave to the hardware. Reference "zero": nothing comes back that was not given before.
 * "measured": the work of the measured force on the robot, whose motion is a dead time old; so is then `given`, but
 * for what the controller has taken since, which counts at once.
 *
 * Damping: the force a v, a = deficit / (horizon v^2), at most damping_max: near v = 0 what cannot be taken is
 * carried over. Tank: the force, where it pushes the manipulator on, by the share of the credit that is left.
 * A credit is a surplus of that much at the start, and the most that is kept of one: what was dissipated long ago
 * does not hide what happens now. */
#ifndef FIRMWARE_COMPENSATION_PASSIVITY_H
#define FIRMWARE_COMPENSATION_PASSIVITY_H

#include "../config.h"
#include "../past.h"

#ifdef __cplusplus
extern "C" {
#endif

struct passivity {
    const struct passivity_config *config;
    int32_t follows_measured;
    double horizon_s;
    double delay_ticks;  /* by which `given` waits for the reference */
    double taken_J;      /* by the controller, in all */
    double forgiven_J;   /* surplus beyond the credit */
    double deficit_J;    /* negative: credit that is left */
    double force_N;      /* of the controller in the step that goes by */
    double position_m;   /* of the manipulator at its begin */
    uint8_t is_open;     /* such a step goes by */
    struct past given_J; /* without what the controller took */
};

/* Enough ticks are kept for the delay. */
int passivity_fits(const struct app_config *config);

void passivity_start(struct passivity *passivity, const struct app_config *config);

/* Energies of the account up to now, in J. */
struct passivity_energies {
    double simulated_port_J;
    double measured_port_J;
};

/* One tick, before the manipulator's step: the force that it is to have, of the one that it would have, in N. */
double passivity_step(struct passivity *passivity, const struct passivity_energies *energies, double position_m,
                      double velocity_m_per_s, double force_N);

/* The manipulator does not move in this tick: the account begins anew. */
void passivity_rest(struct passivity *passivity);

#ifdef __cplusplus
}
#endif
#endif
