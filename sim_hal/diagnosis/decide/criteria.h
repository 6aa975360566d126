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

/* Rows, 1: a logger's buffers are shorter. A choice; twice as many take twice as long to look. */
inline constexpr int late_rows_max = 12;

/* Rows, 1: a column that stands late does so by whole rows. What is late by any time, as behind a filter, passes for
 * that in twice this share of all cases. */
inline constexpr double late_rows_whole = 0.2;

} // namespace berth::criteria

#endif
