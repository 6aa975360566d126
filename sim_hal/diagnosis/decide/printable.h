/* Whether a cause is fit to print, whatever the verdict: it explains something, its size is not none, and with it
 * data that no fit has seen are predicted better. */
#ifndef SIM_HAL_DIAGNOSIS_DECIDE_PRINTABLE_H
#define SIM_HAL_DIAGNOSIS_DECIDE_PRINTABLE_H

#include <vector>

namespace berth
{

struct cause_evidence {
    double share_explained; /* of the explainable error */
    bool may_be_none;       /* its interval of 95 % holds the size at which it does nothing */
    /* Squared errors on unseen data, a stretch of them each: of the model with the cause, and of that without it,
     * its other parameters fitted anew. Empty: there are none. */
    std::vector<double> unseen_with;
    std::vector<double> unseen_without;
};

/* nullptr: it is. Else why not, to stand behind the name of the effect. */
const char *why_not_printable(const cause_evidence &cause);

/* Of random draws of as many stretches, with putting back: the share in which the error falls. 1 if there are none.
 */
double share_of_draws_that_gain(const cause_evidence &cause);

} // namespace berth

#endif
