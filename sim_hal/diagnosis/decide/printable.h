/* Whether a cause is fit to print, whatever the verdict: it explains something, its size is not none, and with it
 * data that no fit has seen are predicted better. */
#ifndef SIM_HAL_DIAGNOSIS_DECIDE_PRINTABLE_H
#define SIM_HAL_DIAGNOSIS_DECIDE_PRINTABLE_H

#include <vector>

namespace berth
{

struct cause_evidence {
    double share_explained = 0.0; /* of the explainable error */
    bool may_be_none = false;     /* its interval of 95 % holds the size at which it does nothing */
    /* Squared errors on unseen data, a stretch of them each: of the model with the cause, and of that without it,
     * its other parameters fitted anew. Empty: there are none. */
    std::vector<double> unseen_with;
    std::vector<double> unseen_without;
};

/* nullptr: it is. Else why not, to stand behind the name of the effect. */
const char *why_not_printable(const cause_evidence &cause);

/* The same of a rival, which the record cannot tell from a cause: it has a size, and with it unseen data are
 * predicted better, however little sure. */
const char *why_no_rival(const cause_evidence &rival);

/* Share by which the squared error falls, with its 95 % interval. */
struct unseen_gain {
    double value;
    double low;
    double high;
};

unseen_gain gain_of(const cause_evidence &cause);

/* How sure it is: the smaller one of the share of draws that gain, and of the odds of BIC against the best model
 * without it. */
double probability_of(const cause_evidence &cause, double delta_bic);

/* The same of one that has no stretches of its own. */
double probability_of(double delta_bic);

/* Of random draws of as many stretches, with putting back: the share in which the error falls. 0 if there are none:
 * nothing proves nothing. */
double share_of_draws_that_gain(const cause_evidence &cause);

} // namespace berth

#endif
