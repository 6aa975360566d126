/* Squared errors of rows that no fit has seen, in stretches: what a cause is proved with. */
#ifndef SIM_HAL_DIAGNOSIS_DECIDE_STRETCHES_H
#define SIM_HAL_DIAGNOSIS_DECIDE_STRETCHES_H

#include <vector>

#include "printable.h"

namespace berth
{

inline constexpr std::size_t unseen_stretches = 12; /* enough that a normal quantile holds for their sum */
/* With fewer that show a cause, all rows are held out in turn. */
inline constexpr std::size_t stretches_wanted = unseen_stretches / 2;

/* Of the rows that count, shared over so many stretches in their order: sums. */
std::vector<double> sums_by_stretch(const std::vector<double> &values, const std::vector<bool> &counts,
                                    std::size_t stretches);

/* The squared errors of a model with the cause, and of one without it, over the stretches. */
struct compared_stretches {
    std::vector<double> with;
    std::vector<double> without;
    std::vector<double> change; /* squares of what the cause does to the replay */
};

/* Adds those in which it does more than the noise, `noise` in each, or a tenth of what it does on average: the
 * others neither prove nor refute it. */
void add_what_shows(cause_evidence &made, const compared_stretches &all, double noise);

} // namespace berth

#endif
