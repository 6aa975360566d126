/* The sentences of a verdict, without the decision. */
#ifndef SIM_HAL_VERDICT_WORDS_H
#define SIM_HAL_VERDICT_WORDS_H

#include <string>
#include <vector>

#include "margin.h"
#include "verdict.h"

namespace berth
{

/* As printf, up to three numbers. */
std::string with_numbers(const char *format, double a, double b = 0.0, double c = 0.0);

/* What stopped a run, as "the position limit"; and in a sentence with its time. */
std::string words_of(stop_cause cause);
std::string stop_words(const run_stop &stop);

/* "the eigenvalues say -0.298 /s" */
std::string predicted_words(const growth_prediction &prediction);
std::string with_prediction(std::string text, const growth_prediction &prediction);

/* "each bounce returns 1.08 of its speed: energy is gained"; of a prediction that has a restitution. */
std::string gaining_words(const growth_prediction &prediction);

/* Where bounces of a run lose, and that of a tool whose operator rests at the surface gains; empty: they do not
 * differ.
 */
std::string relaxed_words(const bounce_finding &seen, const growth_prediction &prediction);

/* How well the robot follows an operator. */
std::string tracking_words(const tracking_error &tracking);

/* Why the motion does not show what the model says; empty: what stopped the run says it. */
std::string not_shown_words(const motion_evidence &motion);

/* Where a loop is judged as if it did not change: "; without what changes it from tick to tick (...)"; empty:
 * nothing does. */
std::string left_out_words(const std::vector<std::string> &varies);

/* Why a run need not do what the model says of small motions. */
std::string beyond_words(const growth_prediction &prediction);

/* ": halves every 2.32 s" */
std::string factor_words(const growth_finding &growth);

/* "the oscillation decays by 0.29836 +- 0.00004 /s at 0.9285 Hz: halves every 2.32 s" */
std::string measured_words(const growth_finding &growth);

/* What has to be known beside a growth that was measured with an arm's motors at their limits; empty: none were. */
std::string motor_words(const motion_evidence &motion);

/* Where a run's growth lies far outside of the predicted one, outside three intervals and a factor of 2: both, why,
 * and which to believe; empty: it does not. */
std::string caveat_words(const motion_evidence &motion, const growth_prediction &prediction);

/* What has to be known of a run in which limits acted most of the time; empty: they did not. */
std::string limited_words(const motion_evidence &motion);

/* Where a led force came to its limit: what, since when, and what to do; empty: it never did. */
std::string led_words(const motion_evidence &motion);

/* "the dead time may grow by 12.3 ms before the loop is unstable; modulus 0.5389 (0: unstable)"; empty: nothing is
 * known of it, as of an unstable loop. */
std::string margin_words(const stability_margin &margin);

/* 0.298364 with an interval of 4e-05: "0.29836 +- 0.00004"; exact: three digits. */
std::string rate_text(double value, double ci95);

} // namespace berth

#endif
