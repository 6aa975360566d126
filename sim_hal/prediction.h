/* What the model says of a loop's growth before anything moves. */
#ifndef SIM_HAL_PREDICTION_H
#define SIM_HAL_PREDICTION_H

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "../hal/rig/rig.h"
#include "stability/equivalent_loop.h"
#include "stability/tool_loops.h"

namespace berth
{

/* Eigenvalues of more states take more than a second. */
constexpr int predicted_degree_max = 400;

enum class prediction_source {
    none,
    eigenvalues,       /* of one period */
    contact,           /* the same, of a tool while it stays in contact */
    lyapunov_exponent, /* of a loop that changes from tick to tick */
    run,               /* of a compensation that has no eigenvalues: how the swing of a run without noise grows */
    free_flight,       /* of one period of a tool away from the material, where that grows and contact does not */
};

/* Of a loop that a schedule makes from a time on. */
struct scheduled_growth {
    double from_s; /* on the clock of the run */
    double dead_time_ms;
    double stiffness_N_per_m;
    std::optional<double> growth_per_s;
    double ci95_per_s;
    std::optional<bool> is_stable; /* nothing: not known */
};

struct growth_prediction {
    std::optional<double> growth_per_s;
    std::string why_not;     /* where there is none */
    double ci95_per_s = 0.0; /* of a Lyapunov exponent, or of a run */
    prediction_source source = prediction_source::none;
    std::int64_t ticks = 0;   /* of a Lyapunov exponent */
    double amplitude_m = 0.0; /* of the swing at which effects of size were taken; 0: small motions */

    /* Of a rig that schedules a change of its loop, see schedule.h: all loops in order of time, this one is the
     * worst. Empty: nothing is scheduled. */
    std::vector<scheduled_growth> schedule = {};

    std::optional<double> restitution = {}; /* of a tool that touches and leaves, see bounce.h */
    bool never_touches = false;             /* the tool does not come to the object in the rig's own run */

    bool gains_by_bounces() const { return restitution && *restitution > 1.0; }
    bool grows_in_flight() const { return source == prediction_source::free_flight; }
};

/* True: decays. Nothing: there is no growth, or it is no larger than its interval or rounding. A tool whose bounces
 * gain energy is not stable, even if it is while it stays in contact. */
std::optional<bool> is_stable(const growth_prediction &prediction);
std::optional<bool> is_stable_in_contact(const growth_prediction &prediction);

/* What predicts the growth of a rig. */
using growth_predictor = std::function<growth_prediction(const rig &)>;

/* From the eigenvalues, or the Lyapunov exponent, of the loop without noise and limits, and what a bounce does: what
 * every command says of a rig's small motions. Of a rig that schedules a change of its loop, the worst growth of its
 * schedule. */
growth_prediction predict_growth(const rig &rig);

/* The same of the loop as it is at the start, whatever is scheduled. */
growth_prediction predict_unscheduled(const rig &rig);

/* Of the eigenvalues of a linear rig. */
growth_prediction prediction_of(double growth_per_s, const rig &linear, prediction_source source);

/* Adds what a bounce of the rig's tool does to a prediction of the tool that stays in contact. Other rigs have none.
 */
void add_bounces(growth_prediction &held, const rig &rig);

/* What a tool does away from the material takes the place of a prediction that holds it there, if the one grows and
 * the other does not. Other rigs have none. */
void add_flight(growth_prediction &held, const rig &rig);

/* The swings that last by harmonic balance, of a loop with play, friction or another effect of size, about a swing
 * of this height from crest to trough. Empty: there are none, or they take long to find; arms and compensation have
 * none here. */
std::vector<limit_cycle> predict_cycles(const rig &rig, double height_m);

} // namespace berth

#endif
