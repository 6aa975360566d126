#include "run_advice.h"

#include "../hal/rig/rig_file.h"
#include "compensated.h"
#include "effects/effect.h"
#include "schedule.h"
#include "stability/compensation_states.h"

namespace berth
{

namespace
{

constexpr double run_factors[] = {1.25, 1.75, 3.0};
constexpr int run_digits = 3;
constexpr int runs_most = 12; /* each a run or three, of up to 100 s */

/* What lowers the loop's gain or delay, or the play in it, and what damps it. */
constexpr struct {
    const char *key;
    bool is_raised;
} changes[] = {
    {"robot.dead_time_ms", false},
    {"object.stiffness_N_per_m", false},
    {"object.mass_kg", false},
    {"manipulator.mass_kg", true},
    {"manipulator.damping_N_s_per_m", true},
    {"robot.backlash_m", false},
    {"robot.deadband_m", false},
    {"object.backlash_m", false},
    {"manipulator.backlash_m", false},
    {"sensor.low_pass_frequency_Hz", true},
};

/* Empty where the rig is not stable, or not seen to be. */
growth_prediction predict_by_run(const rig &rig)
{
    if (!is_told_by_runs(rig)) {
        return predict_unscheduled(rig);
    }
    const stability_verdict verdict = growth_of_compensated(rig).verdict;
    if (verdict.is_stable != std::optional<bool>(true)) {
        return {{}, verdict.because};
    }
    if (growth_prediction small = predict_unscheduled(rig); is_stable(small) == std::optional<bool>(false)) {
        return small; /* what grows is too small to be seen in the run */
    }
    return verdict.growth ? growth_prediction{verdict.growth->growth_per_s,
                                              {},
                                              verdict.growth->ci95_per_s,
                                              prediction_source::run}
                          : predict_compensated(rig);
}

growth_prediction predict(const rig &rig)
{
    return worst_of_schedule(rig, predict_by_run).prediction;
}

/* What is small enough meets no limit of a drive: it grows as predicted, whatever becomes of the swing. */
std::optional<parameter_cure> change_of_small(const rig &original)
{
    rig small = original;
    small.robot.velocity_limit_m_per_s = small.robot.acceleration_limit_m_per_s2 = unlimited;
    if (is_told_by_runs(small) || is_stable(predict_growth(small)) != std::optional<bool>(false)) {
        return {};
    }
    return advise(small).change;
}

std::optional<parameter_cure> change_by_factors(const rig &rig)
{
    int tries = 0;
    for (const double factor : run_factors) {
        for (const auto &[key, is_raised] : changes) {
            const double own = value_of(rig, key);
            const double value = is_raised ? own * factor : own / factor;
            if (!(own > 0.0)) {
                continue;
            }
            if (tries++ == runs_most) {
                return {};
            }
            if (auto found = tried_cure(rig, key, rounded_beyond(value, own, run_digits), predict)) {
                return found;
            }
        }
    }
    return {};
}

} // namespace

bool is_told_by_runs(const rig &rig)
{
    return is_judged_by_runs(rig) || !compensation_is_linear(rig);
}

stability_advice advise_by_runs(const rig &rig)
try {
    stability_advice made;
    made.was_sought = true;
    made.compensation = find_compensation(rig, predict);
    const auto small = change_of_small(rig);
    if (small) {
        made.change = tried_cure(rig, small->key, small->value, predict);
    }
    if (!made.change) {
        made.change = change_by_factors(rig);
    }
    if (small && !made.change && !made.compensation) {
        made.change = small;
        made.caveat = "for small motions; this rig's own swing meets the drive's limits all the same";
    }
    return made;
} catch (const input_error &) {
    return {};
}

} // namespace berth
