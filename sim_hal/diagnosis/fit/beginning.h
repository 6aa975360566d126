/* The first rows of a block's record: often enough to see that a start of a search promises nothing. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_BEGINNING_H
#define SIM_HAL_DIAGNOSIS_FIT_BEGINNING_H

#include <optional>

#include "response.h"

namespace berth
{

class beginning
{
  public:
    /* `incumbent`: fitted over the whole record, with the slopes of its parameters and its white error there. */
    beginning(const block_model &whole, const noise_model &noise, const fit_result &incumbent,
              const known_slopes &slopes, const Eigen::VectorXd &white);
    beginning(const beginning &) = delete; /* the model looks at the record beside it */
    beginning &operator=(const beginning &) = delete;

    /* Of no share, from `least` to `most`, of what `rig` changes is the sum of squares over the whole record smaller
     * by `worth`, whatever the parameters make up for: these rows alone have more left. Never true of the
     * manipulator, whose windows all begin anew, nor where the beginning by itself begins otherwise. Exact but for a
     * start with play or a dead band that nothing crosses so early: where it begins is looked for in these rows. */
    bool rules_out(const rig &rig, double least, double most, double worth);

  private:
    record record_;
    sample_events events_;
    block_model model_;
    const noise_model &noise_;
    Eigen::VectorXd here_;
    double whole_square_;
    std::optional<tangent_space> base_; /* none: rules nothing out */
    tangent_space::target target_;
};

} // namespace berth

#endif
