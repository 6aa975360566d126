/* Verdict, delay budget and assumptions, for a person and for a program. What is printed here was made by the
 * library. */
#ifndef SIM_HAL_CLI_VERDICT_REPORT_H
#define SIM_HAL_CLI_VERDICT_REPORT_H

#include <nlohmann/json.hpp>

#include "../berth.h"
#include "commands.h"

namespace berth
{

/* In its colour. */
std::string stability_word(bool is_stable);

/* Of a verdict on the loop by itself: `berth run` will have none where the rig's own run never closes the loop. */
void add_caveat_of_run(stability_verdict &verdict, const rig &rig);

/* Lines of a summary. */
void print_verdict(const stability_verdict &verdict);
void print_caveat(const stability_verdict &verdict); /* nothing where there is none */
void print_assumptions(const rig &rig);
void print_delay_budget(const rig &rig);
void print_schedule(const growth_prediction &prediction); /* nothing where nothing is scheduled */

/* "stable, Lyapunov exponent -0.179 /s (+-0.08) over 400000 ticks, seed 1"; why there is none. */
std::string exponent_sentence(const growth_prediction &exponent, std::int64_t seed);

/* One line, after a headline. */
void print_because(const stability_verdict &verdict);

/* Where more than the eigenvalues decides: the verdict first, and they apart from it. */
void print_unlike_eigenvalues(const std::string &rig_name, const stability_verdict &verdict, double spectral_radius,
                              double growth_per_s);

/* A growth of eigenvalues beside a verdict by runs: null where it goes the other way. */
nlohmann::json growth_beside(const stability_verdict &verdict, const nlohmann::json &growth_per_s);

void print_margin(const stability_margin &margin);
void print_peaks(const motion_evidence &motion);

/* 0, or 1 where --check asks for more than the verdict gives. */
int check_exit_code(const rig_arguments &arguments, const stability_verdict &verdict,
                    const stability_margin &margin);

/* What every answer has: verdict, its reason and advice, margin, delay budget, and what was assumed. */
nlohmann::json answer_json(const rig &rig, const stability_verdict &verdict, const stability_margin &margin);

/* Of small motions: the same in every command. */
nlohmann::json prediction_json(const growth_prediction &prediction);

/* Null where there is nothing to tell. */
nlohmann::json stop_json(const std::optional<run_stop> &stop);
nlohmann::json doubling_json(const stability_verdict &verdict);
nlohmann::json bounces_json(const std::optional<bounce_finding> &bounces);
nlohmann::json tracking_json(const motion_evidence &motion);
nlohmann::json margin_json(const stability_margin &margin);
nlohmann::json assumed_json(const rig &rig);
nlohmann::json delay_budget_json(const rig &rig);
nlohmann::json peaks_json(const motion_evidence &motion);

} // namespace berth

#endif
