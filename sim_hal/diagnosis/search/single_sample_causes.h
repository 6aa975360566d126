/* Causes that were seen in single samples, as the blocks tell them. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_SINGLE_SAMPLE_CAUSES_H
#define SIM_HAL_DIAGNOSIS_SEARCH_SINGLE_SAMPLE_CAUSES_H

#include "block_diagnosis.h"

namespace berth
{

/* Blocks are compared beside them all along. The errors of the rig as given and of the re-tuned one then are those
 * of a rig that knows nothing of them. `unseen`: null where parts of the record are held out. */
void show_error_with_single_samples(std::vector<block_diagnosis> &blocks, const record &data, const record *unseen);

/* A robot's own, which its reports and the force have shown together, are told in the robot's block. */
void tell_in_own_block(std::vector<block_diagnosis> &blocks);

/* Those that explain nothing to speak of are no causes: steps of a coarse sensor look like samples that were held.
 */
void drop_what_explains_nothing(std::vector<block_diagnosis> &blocks, rig &extended);

} // namespace berth

#endif
