/* Each kind of verdict with its words, once verdict.cpp has decided which it is. */
#ifndef SIM_HAL_VERDICT_KINDS_H
#define SIM_HAL_VERDICT_KINDS_H

#include <optional>

#include "verdict.h"

namespace berth
{

growth_finding predicted_finding(const growth_prediction &prediction);

stability_verdict stable_verdict(const verdict_case &of);
stability_verdict unstable_verdict(const verdict_case &of);
stability_verdict driven_verdict(const verdict_case &of);
stability_verdict limit_cycle_verdict(const verdict_case &of);
stability_verdict bounce_verdict(const verdict_case &of, const bounce_finding &bounces);

/* Undetermined: why, and what to do. */
stability_verdict undetermined(std::string because, std::string advice);
stability_verdict stopped_early(const verdict_case &of);
stability_verdict not_told(const verdict_case &of);
stability_verdict never_touches(const growth_prediction &prediction);
stability_verdict neither(const growth_prediction &prediction); /* a growth that is not told from 0 */

/* Of a loop that never ran, or never had its object; nothing: there is motion to judge. */
std::optional<stability_verdict> judge_without_motion(const verdict_case &of);

/* The predicted swing that a motion of this height is: within a factor of two, and one that motion comes to. */
std::optional<limit_cycle> cycle_of(const verdict_case &of);

/* Without limits at work, the growth tells more. */
bool falls_under_limits(const motion_evidence &motion);

} // namespace berth

#endif
