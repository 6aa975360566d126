/* Where the slips of a robot's free clock are: looked for tick by tick, each by the rows in which a block shows it.
 */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_SLIP_TABLE_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_SLIP_TABLE_H

#include <functional>
#include <vector>

#include "../replay/block_model.h"
#include "clock_ways.h"

namespace berth
{

/* By how many ticks slips may be off either way, in which steps, and for how long the block answers to one. */
struct slip_search {
    double ticks_max;
    double ticks_step;
    double answer_s;
};

/* In which rows the block shows that a slip is in another tick; none where slips are too close together. */
struct slip_answers {
    std::vector<double> times_s; /* of the slips */
    std::vector<record_segment> rows;
    double ticks_max = 0.0;
};

slip_answers answers_to_slips(const rig &rig, const record &data, const slip_search &search);

/* Sums of squares about each slip, by how many steps of phase another one would be. With the first and the last slip
 * those between are known. */
class slip_table
{
  public:
    slip_table(block_model &model, const rig &rig, const slip_answers &slips, double ticks_step,
               const clock_ways &ways);

    /* Moves phase and drift so that the sum over all slips is least; true: near the ends of what was tried, so that
     * it may be less further on. */
    bool apply_best(rig &rig, const clock_ways &ways) const;

    struct width {
        double drift_ppm = 0.0;
        double phase_ms = 0.0;
    };

    /* How far drift and phase may be off, where the sum may rise so far above the least. */
    width within(double rise_max) const;

  private:
    struct line {
        int first; /* steps of the first slip, and of the last */
        int last;
        double sum;
    };

    void for_each_line(const std::function<void(const line &)> &visit) const;
    double sum_on(int first, int last) const;
    double turn_ms_per_s(const line &one) const;

    int reach_;
    double step_ms_;
    std::vector<double> times_s_;
    std::vector<std::vector<double>> squares_; /* slip, steps */
};

} // namespace berth

#endif
