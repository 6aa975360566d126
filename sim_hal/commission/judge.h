/* What each stage has shown, against what the rig file says: pure functions of its ticks. The entry that they return
 * has stage, outcome, reason, values and proposal. */
#ifndef SIM_HAL_COMMISSION_JUDGE_H
#define SIM_HAL_COMMISSION_JUDGE_H

#include "../../hal/rig/commissioning.h"
#include "../run_answer.h"
#include "stage_run.h"

namespace berth
{

stage_entry judge_watch(const rig &told, const stage_run &run);

/* One standstill, with gravity as it was in it. */
struct tare_pose {
    std::array<double, 3> gravity_m_per_s2;
    stage_run run;
};

/* `told`: with tare and tool as the file has them. */
stage_entry judge_tare(const rig &told, const std::vector<tare_pose> &poses);

/* What the model says of the whole loop, with the file's values and with the measured ones. */
struct loop_promise {
    std::optional<double> damping_ratio; /* the smallest, of all modes; nothing: no eigenvalues */
    std::optional<double> growth_per_s;
    std::string why_not;              /* there are none */
    std::optional<double> gain_limit; /* from which on the damping is below the margin; nothing: it never is */
};

/* Of a rig; `margin`: damping ratio. */
loop_promise promise_of(const rig &rig, double margin);

stage_entry judge_shadow(const rig &told, const stage_run &run, const loop_promise &measured,
                         const loop_promise &assumed, double margin);
stage_entry judge_ramp(const rig &told, const stage_run &run, double margin);
stage_entry judge_run(const stage_run &run, const run_answer &answer, const loop_promise &measured);

/* By how much the measured force would have moved the manipulator away from what was commanded, at most, in m. */
double shadow_deviation_m(const rig &told, const std::vector<tick_record> &ticks);

} // namespace berth

#endif
