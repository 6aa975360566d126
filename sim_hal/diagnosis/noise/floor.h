/* The noise that a model leaves: the floor under every error. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_FLOOR_H
#define SIM_HAL_DIAGNOSIS_NOISE_FLOOR_H

#include "../replay/block_model.h"
#include "noise.h"

namespace berth
{

/* rms of the steps of the wire, and of how exact the replay is itself: where an effect bends the motion within a
 * step, the stiff sensor shows it. */
double precision_of(const block_model &model);

/* What the noise of a block's channel may be: the manipulator is replayed in windows that each start anew. */
inline colour colour_of(block block)
{
    return block == block::manipulator ? colour::regression : colour::regression_or_slow;
}

/* What is left, as noise. An error whose rows follow from the rows before almost without news is no noise but motion
 * that is not explained yet: weighed as such it would count for nothing. Then all rows weigh alike, and as many of
 * them as hang together say one thing. */
noise_model noise_of(const block_model &model, const std::vector<double> &error, bool is_white);

/* The noise that is left of a rig's error when what depends on the state is taken out: first with all errors alike,
 * then weighted by the noise so found. No smaller than what the wire and the replay itself resolve. */
noise_model floor_under(block_model &model, const rig &rig);

} // namespace berth

#endif
