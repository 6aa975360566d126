/* What an effect has to achieve before it is believed. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_ACCEPTANCE_H
#define SIM_HAL_DIAGNOSIS_SEARCH_ACCEPTANCE_H

namespace berth
{

constexpr double bic_clear = 20.0;     /* an effect must improve BIC by this */
constexpr double bic_undecided = 10.0; /* two causes nearer than this cannot be told apart */
constexpr double bic_look_alike =
    60.0; /* the same for look-alikes: what a wrong tolerance can make of the difference */
/* What no cause explains and yet is better by so much: something else is there. */
constexpr double bic_suspect = 40.0;
constexpr double bic_beyond_doubt = 150.0;
constexpr double share_worthwhile = 0.3; /* of the explainable error */
constexpr double share_of_rest = 0.9;    /* nearly all that is left */
constexpr double held_out_least = 0.05;  /* the same on unseen data */
constexpr double left_full = 0.003;      /* of the explainable error may be left of a full explanation */

} // namespace berth

#endif
