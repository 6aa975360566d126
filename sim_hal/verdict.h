/* One verdict on a loop, from what the model predicts and what the motion shows: a pure function of both. */
#ifndef SIM_HAL_VERDICT_H
#define SIM_HAL_VERDICT_H

#include <optional>
#include <string>
#include <vector>

#include "advice.h"
#include "bounce_finding.h"
#include "margin.h"
#include "motion.h"
#include "prediction.h"
#include "stability/equivalent_loop.h"

namespace berth
{

enum class verdict_kind {
    stable,
    unstable,
    limit_cycle,  /* swings for ever at one height */
    driven,       /* an operator moves it: how well it tracks, and stable by prediction */
    bouncing,     /* a tool touches and leaves, and loses energy each time; one that gains is unstable */
    undetermined, /* the exception: `because` says why, `advice` what to do */
};

/* The words of terminal, JSON, page and picture. */
const char *verdict_name(verdict_kind kind);

enum class growth_origin {
    measured, /* in the run that is judged */
    predicted,
    trial, /* measured in a run without noise that berth made for this */
};

const char *growth_origin_name(growth_origin origin);

/* A rate that is larger than its uncertainty. */
struct growth_finding {
    growth_origin origin;
    double growth_per_s; /* less than 0: decays */
    double ci95_per_s;   /* 0: exact */
    double frequency_Hz; /* 0: not known */

    /* In which the motion doubles, or halves. */
    double factor_time_s() const;
};

/* What a verdict is made of. */
struct verdict_case {
    growth_prediction prediction;
    motion_evidence motion;
    stability_margin margin;
    stability_advice advice; /* of a loop that is predicted to be unstable */
    double manipulator_mass_kg = 0.0;
    std::vector<limit_cycle> cycles; /* of harmonic balance, see predict_cycles() */
    std::string obstacles;           /* what kept a loop that never ran from running; empty: not known */
};

struct stability_verdict {
    verdict_kind kind = verdict_kind::undetermined;
    std::optional<bool> is_stable;
    std::optional<growth_finding> growth;
    std::optional<bounce_finding> bounces;
    std::optional<run_stop> stop; /* what stopped the run before its time */
    std::string because;          /* one sentence */
    std::string advice;           /* one line; empty: none is needed */
    std::string caveat;           /* where prediction and this run differ: which to believe; empty: they agree */
};

/* Of a run. */
stability_verdict judge(const verdict_case &of);

/* Of the model alone, as `eigen` and `limits` have it. */
stability_verdict judge(const growth_prediction &prediction, const stability_advice &advice);

/* Stable, and with this margin of dead time left. */
bool is_safe(const stability_verdict &verdict, const stability_margin &margin, double margin_ms);

} // namespace berth

#endif
