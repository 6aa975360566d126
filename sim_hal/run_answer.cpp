#include "run_answer.h"

#include <memory>

#include "../firmware/loop.h"
#include "bounce_finding.h"
#include "hil/manipulator_stand_in.h"
#include "hil/sim_hal.h"
#include "stability/arm_loop.h"
#include "start_trial.h"
#include "verdict_words.h"

namespace berth
{

namespace
{

/* Noise and a short run may hide how a loop with play or friction swings, which is not predicted otherwise. */
stability_verdict told_by_a_run_without_noise(const stability_verdict &of, const motion_evidence &motion,
                                              const stability_verdict &without_noise)
{
    const bool grows = without_noise.is_stable == std::optional<bool>(false);
    const bool is_open = of.kind == verdict_kind::undetermined || of.kind == verdict_kind::stable ||
                         ((of.kind == verdict_kind::driven || of.kind == verdict_kind::bouncing) && grows);
    const bool is_whole =
        motion.has_moved && motion.has_touched && (!motion.stop.is_early() || (motion.stop.is_of_motion() && grows));
    if (!is_open || !is_whole || without_noise.is_stable == of.is_stable) {
        return of;
    }
    stability_verdict found = without_noise;
    found.stop = of.stop;
    found.because += "; this run alone does not tell" + (of.stop ? ": " + stop_words(*of.stop) : "");
    return found;
}

/* What an operator moves, and what touches now and then, does not show how the loop by itself goes on. */
void predict_by_the_run_without_noise(growth_prediction &prediction, const motion_evidence &evidence,
                                      const stability_verdict &without_noise)
{
    if (!prediction.growth_per_s && without_noise.growth && (evidence.is_driven || is_bouncing(evidence))) {
        prediction.growth_per_s = without_noise.growth->growth_per_s;
        prediction.ci95_per_s = without_noise.growth->ci95_per_s;
        prediction.source = prediction_source::run;
        prediction.why_not.clear();
    }
}

} // namespace

run_answer answer_of_run(const rig &rig, const motion_evidence &evidence, const std::string &obstacles,
                         answer_scope scope)
{
    const model_answer model = answer_of(rig, {}, {}, scope);
    verdict_case all{model.worst.prediction,           evidence, model.margin, model.advice,
                     rig.firmware.manipulator.mass_kg, {},       obstacles};
    if (model.by_runs) {
        predict_by_the_run_without_noise(all.prediction, evidence, *model.by_runs);
    }
    if (evidence.falls == std::optional<bool>(false)) {
        all.cycles = predict_cycles(rig, evidence.height_m);
    }
    run_answer made{all.prediction, model.margin, judge(all)};
    if (model.by_runs) {
        made.verdict = told_by_a_run_without_noise(made.verdict, evidence, *model.by_runs);
    }
    if (!evidence.has_run || made.verdict.is_stable == std::optional<bool>(false)) {
        made.margin = {};
    }
    return made;
}

played_run play(const rig &rig, const std::string &log_path, answer_scope scope)
{
    refuse_unstable_steps(rig);
    sim_options options;
    options.log_path = log_path;
    const auto app = std::make_unique<struct app>();
    const std::unique_ptr<struct hal, hal_status (*)(struct hal *)> open_hal(sim_open(rig, options), hal_close);
    struct hal *hal = open_hal.get();
    app_start(app.get(), &rig.firmware);
    manipulator_stand_in manipulator(rig);
    motion_recorder motion(rig);
    played_run run;
    bool has_run = false;
    while (app->supervisor.state != SUPERVISOR_STOPPED && loop_tick(hal, app.get()) == HAL_OK) {
        const tick_record &tick = app->recorder.tick;
        run.ticks.push_back(tick);
        motion.note_tick(tick, app->arm_record.motors_at_limit != 0, sim_rig(hal).truth().spring_force_N);
        has_run = has_run || tick.state == SUPERVISOR_RUNNING;
        manipulator.replace(*app);
    }
    sim_log(hal).drain();
    run.evidence = motion.conclude();
    run.answer = answer_of_run(rig, run.evidence, has_run ? "" : obstacles_of(rig, app->recorder.tick), scope);
    return run;
}

} // namespace berth
