/* A rig's loop at one size of its motion, made linear, and what it predicts. */
#ifndef SIM_HAL_LOOP_AT_AMPLITUDE_H
#define SIM_HAL_LOOP_AT_AMPLITUDE_H

#include "prediction.h"
#include "stability/equivalent_loop.h"

namespace berth
{

/* The amplitude that is taken: 0, small motions, where nothing in the rig depends on it; what was asked for; else
 * the usual one. A tool in contact depends on it where somebody asks. */
double amplitude_of(const rig &rig, std::optional<double> asked_m = {});

/* The rig, a tool held in contact, or what is equivalent to it at an amplitude greater than 0. */
struct settled_rig {
    rig linear;
    bool has_settled; /* its frequency and its phases agree */
};
settled_rig settle_at(const rig &rig, double amplitude_m);
rig linear_at(const rig &rig, double amplitude_m);

/* What predicts at an amplitude, or of small motions at 0: predict_unscheduled(), without its limit on the number of
 * eigenvalues, and of a loop that changes from tick to tick over `ticks` ticks (0: as many as it takes). */
growth_predictor predictor_at(double amplitude_m, std::int64_t ticks = 0);

} // namespace berth

#endif
