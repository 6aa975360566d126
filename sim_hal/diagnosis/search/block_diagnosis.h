/* What is wrong in one block, and why. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_BLOCK_DIAGNOSIS_H
#define SIM_HAL_DIAGNOSIS_SEARCH_BLOCK_DIAGNOSIS_H

#include <memory>
#include <optional>
#include <string>

#include "../samples/events.h"
#include "search.h"

namespace berth
{

enum class verdict { nothing_detectable, named, one_of, partly_explained, unknown, software_mismatch };

constexpr std::string_view verdict_names[] = {"nothing_detectable", "named",   "one_of",
                                              "partly_explained",   "unknown", "software_mismatch"};

struct parameter_estimate {
    std::string key;
    double value;
    double ci95;
};

struct cause {
    const berth::effect *effect;
    std::vector<parameter_estimate> parameters;
    double delta_bic = 0.0;
    double share_explained = 0.0;
    bool is_shown_by_force = false; /* told in the robot, where it happens; the share is of the force's error */
    double held_out_gain = 0.0;     /* share by which the held-out sum of squares falls */
    double held_out_gain_low = 0.0;
    double held_out_gain_high = 0.0;
};

struct alternative {
    const berth::effect *effect;
    double delta_bic;                        /* to the winner, positive: worse */
    const berth::effect *rival_of = nullptr; /* the cause in whose place it would stand; nullptr: the last one */
    fit_result fitted = {};                  /* all of it in its place; empty: it is in the ranking */
};

/* How a candidate did in one round of the search. */
struct ranked {
    int round;
    const berth::effect *effect;
    double delta_bic;       /* to the model of the round before, positive: better */
    double share_explained; /* of the explainable error */
    fit_result fitted;
};

struct part_rms {
    double before = 0.0;  /* the rig as given */
    double retuned = 0.0; /* within its tolerances */
    double after = 0.0;
    double floor = 0.0;
};

/* A doubt that another experiment than the others' settles. */
inline constexpr std::string_view friction_may_fall =
    "friction that falls with speed acts as dry friction and less damping do";

struct block_diagnosis {
    berth::block block;
    berth::verdict verdict = verdict::nothing_detectable;
    std::vector<cause> causes;
    std::vector<alternative> alternatives;
    std::vector<std::string> doubts; /* why it is not fully explained */
    std::vector<ranked> ranking;
    std::vector<const effect *> tried; /* in the first round; the most promising ones are ranked */
    part_rms fit_rms;
    part_rms held_out_rms;
    double unseen_times_noise = 0.0; /* error on the validation record, where it is far above the noise; else 0 */
    double bad_moments = 0.0;        /* share of half seconds with an error well above the floor, after */
    bool floor_is_measured = false;
    double explainable = 0.0; /* white sum of squares above the floor, per row, of the re-tuned base */
    double left = 0.0;        /* share of it that is left and depends on the state or on time */
    error_class left_class = error_class::linear;
    std::vector<free_parameter> refinable; /* what was fitted, as a prior for the blocks after it */
    berth::rig as_given;                   /* with what blocks before it have shown */
    berth::rig retuned;                    /* the same with the base fitted */
    berth::rig extended;                   /* and with the effects */
    fit_result fitted;                     /* what `extended` came from, without single samples */
    std::vector<parameter_estimate> base;
    std::vector<row_use> uses; /* one a row, as the two below */
    std::vector<double> error_before;
    std::vector<double> error_after;
    /* The same without causes that are not fit to print; nullptr: all are. What looks further goes on from all. */
    std::shared_ptr<block_diagnosis> printable;
    noise_model floor;
    double floor_ci95 = 0.0;      /* half width of the interval of its rms */
    double input_steps_rms = 0.0; /* what too few digits of what drives it leave open; 0: nothing */
    bool force_decided = false;   /* of a robot: which of the causes it is that its reports cannot tell apart */
};

/* What too few digits of its input leave open counts beside its noise. */
inline bool is_open_by_input_steps(const block_diagnosis &block)
{
    constexpr double counts = 0.2; /* of the noise */
    return block.input_steps_rms > counts * block.floor.rms;
}

struct diagnosis_input {
    const record *fit = nullptr;
    const record *validation = nullptr; /* or parts of `fit` are held out */
    std::optional<noise_model> floor;   /* measured at standstill or by repetition */
    bool floor_is_of_replays = false;   /* of two runs that did not go the same way */
    search_options options;
    int effects_max = 3;
    bool may_search_again = false;        /* without a cause that may stand in for others; takes as long again */
    std::vector<free_parameter> upstream; /* see refinable */
    bool has_events = false;              /* single samples were found to be lost or thrown off: some more may be */
    bool has_cause_upstream = false;      /* the motion comes from a robot with a fault of its own */
    const rig *without_switching_fault = nullptr; /* the rig as given, where that fault is one of thresholds */
};

block_diagnosis diagnose_block(block block, const diagnosis_input &input, const rig &given,
                               events_of_records &events, std::vector<event_finding> found_events);

} // namespace berth

#endif
