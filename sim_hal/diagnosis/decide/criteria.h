/* The numbers that decide what is printed and under which verdict. */
#ifndef SIM_HAL_DIAGNOSIS_DECIDE_CRITERIA_H
#define SIM_HAL_DIAGNOSIS_DECIDE_CRITERIA_H

namespace berth::criteria
{

/* Share of the explainable error, 1: less is printed as 0.0 %. */
inline constexpr double share_explained_least = 5e-4;

/* Share of random draws of unseen stretches in which a cause lowers the error, 1. */
inline constexpr double share_of_draws_least = 0.99;

/* Times the noise, 1: an error on unseen data that is the first thing to say. Twice the noise is three times what
 * the noise leaves, as squares. */
inline constexpr double unseen_far = 2.0;

} // namespace berth::criteria

#endif
