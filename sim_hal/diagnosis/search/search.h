/* Which effect of the library explains the error of a block. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_SEARCH_H
#define SIM_HAL_DIAGNOSIS_SEARCH_SEARCH_H

#include <functional>
#include <memory>
#include <vector>

#include "../fit/fit.h"
#include "../noise/leftover.h"
#include "work_limit.h"

namespace berth
{

/* An effect fitted together with the base model's parameters and the effects found before. */
struct candidate {
    const berth::effect *effect = nullptr;
    fit_result fitted;
    double bic = 0.0;
    double white_cost = 0.0; /* under the noise that all candidates are compared with */
};

/* Those whose replay leaves all bounds are none. */
void drop_diverged(std::vector<candidate> &candidates);

struct search_options {
    std::vector<std::string> without; /* effects that are not to be tried */
    bool robot_in_force = false;      /* what its own noise may hide of the robot, too */
    /* Found last, and decides what follows: beside it only what moves nothing is tried, as all else could be a finer
     * way of it. */
    const effect *decider = nullptr;
    std::function<void(const effect &)> tell; /* is told which one is tried next; may be empty */
    std::shared_ptr<work_limit> limit;        /* empty: none */
    int fits_max = 5;
    int replays_max = 120;      /* of the fit of a candidate */
    int base_replays_max = 250; /* of the base model, on which all others stand */
};

void tell(const search_options &options, const effect &effect);

/* The limit of work is over; remembers that this one is left out. */
bool is_left_out(const search_options &options, const effect &effect);

/* In the force, whatever switches in the robot makes the error jump with its size. */
bool is_rough_here(const effect &effect, const search_options &options);

/* It says more about one that was found; by itself it is one like others. */
bool is_refining(const effect &effect, const std::vector<const berth::effect *> &found);

/* The search has this effect on its list: it acts in the block, is fitted, not found before, not left out. */
bool is_tried(const effect &effect, block_model &model, const rig &given,
              const std::vector<const berth::effect *> &found, const search_options &options);

/* All of them; none once the limit of work is over. */
std::vector<const effect *> effects_to_try(block_model &model, const rig &given,
                                           const std::vector<const effect *> &found, const search_options &options);

/* How large things are in this block. */
record_scales scales_of(block_model &model, const rig &rig, const std::vector<double> &error,
                        const search_options &options = {});

/* Tries every effect that acts in the block and is not in `found`: first one replay for each start, projected on
 * what the base model could make up for; then a fit of the most promising ones. Best BIC first. */
std::vector<candidate> search_effects(block_model &model, const noise_model &noise, const fit_result &incumbent,
                                      const rig &given, const std::vector<const effect *> &found,
                                      const search_options &options);

/* An effect of one size, searched on a grid from the start divided by `factor` to its multiple, which closes in on
 * the best one, with the base model fitted in between. The usual factor is about the spacing of the starts. */
fit_result fit_rough(block_model &model, const noise_model &noise, const effect &effect, const rig &start,
                     const fit_result &incumbent, const search_options &options, double factor = 1.3);

/* Of an effect whose error jumps with its size: how far that may be off while the error stays the same. */
double width_of_size(block_model &model, const noise_model &noise, const fit_result &fitted, std::string_view key);

/* An effect fitted anew, beginning where it was `found`, together with the incumbent's parameters. */
fit_result fit_effect(block_model &model, const noise_model &noise, const effect &effect, const fit_result &found,
                      const fit_result &incumbent, const search_options &options);

/* Of an effect that decides what follows, beside what the incumbent has; `starts`: its sizes. Where a wrong size on
 * the way has led all that followed astray, the base with it, the way back is found from the values that are
 * expected, with sizes about the end. */
fit_result fit_what_decides(block_model &model, const noise_model &noise, const effect &effect,
                            const fit_result &incumbent, const std::vector<rig> &starts,
                            const search_options &options);

/* Rows ln(cost / rows) + parameters ln(rows): smaller is better. */
double bic_of(double cost, std::size_t rows, std::size_t parameters);

} // namespace berth

#endif
