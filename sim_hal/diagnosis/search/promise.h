/* Which sizes of which effects are worth a fit. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_PROMISE_H
#define SIM_HAL_DIAGNOSIS_SEARCH_PROMISE_H

#include <vector>

#include "../fit/response.h"
#include "search.h"

namespace berth
{

/* Of the white sum of squares; what decreases it by less is no cause. */
inline constexpr double worth_a_fit = 10.0;

/* A size of an effect, and how much it promises. */
struct start_point {
    const berth::effect *effect;
    berth::rig rig;
    double promise; /* decrease of the white sum of squares */
    bool is_hidden; /* by the noise of the robot's reports: of many thresholds, no size need promise much */
    bool is_regressed = false;         /* all sizes are as the equation of motion has them */
    double promise_beside_known = 0.0; /* with what a block before knows held where it is */
};

/* The starts of all effects that are to be tried, the most promising first; `here`: the incumbent's white error,
 * `slopes`: its slopes there. */
std::vector<start_point> starts_by_promise(block_model &model, const noise_model &noise, const fit_result &incumbent,
                                           const Eigen::VectorXd &here, const known_slopes &slopes, const rig &given,
                                           const std::vector<const effect *> &found, const search_options &options);

/* One of each effect that was not fitted, and with what a block before knows held would explain as much as any. */
std::vector<start_point> promising_beside_known(const std::vector<start_point> &starts,
                                                const std::vector<candidate> &fitted);

/* One of each effect that was not fitted, though one that contains it was, or one that hardly any record can tell
 * from it: promises let the base go where it may not, and what moves the error as the base does promises nothing.
 * `cost`: the incumbent's. */
std::vector<start_point> kin_of_fitted(const std::vector<start_point> &starts, const std::vector<candidate> &fitted,
                                       double cost);

} // namespace berth

#endif
