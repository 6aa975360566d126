/* Whether a run was stable, from its motion; no answer where the run does not tell. */
#ifndef SIM_HAL_CLI_VERDICT_H
#define SIM_HAL_CLI_VERDICT_H

#include <optional>

#include "run_result.h"

namespace berth
{

/* A measured growth decides, if its interval does not hold 0, unless limits still acted at the end: they turn a
 * growing oscillation into one of constant height, which then has to fall to count as stable. Without oscillation, a
 * run that came to its end is stable if it hardly moves in its second half any more, and unstable if it moves more
 * than in its first. Nothing: it was in between, the loop never ran, or never with the object gripped, was stopped
 * before there was enough motion to judge, never moved, ended before it could have swung often enough or growth
 * could be told from decay, or an operator ordered the arm elsewhere. `half_swing_s`: of the manipulator by itself;
 * what is seen to be slower counts as it is. */
std::optional<bool> judge(const run_result &result, double period_s, double half_swing_s);

/* For a person: the verdict, and the growth rate or why there is none. */
void print_verdict(const run_result &result, const rig &rig);

} // namespace berth

#endif
