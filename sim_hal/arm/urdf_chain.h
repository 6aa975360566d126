/* Which joints of a URDF tree are an arm's, and where the others are held: decisions on the tree, no mechanics. */
#ifndef SIM_HAL_ARM_URDF_CHAIN_H
#define SIM_HAL_ARM_URDF_CHAIN_H

#include <string>
#include <vector>

#include "urdf.h"
#include "urdf_model.h"

namespace berth
{

struct urdf_chain {
    std::string base; /* link */
    std::string tool; /* link */
    bool floats;      /* a floating joint leads to the base */
    /* Places in model.joints(), from base to tool: at most ARM_JOINTS_MAX. */
    std::vector<std::size_t> moving;
    std::size_t movable; /* joints on the way that could move, more than `moving` where an arm cannot have all */
};

/* From choice.base to choice.tool. Without the first from where the tool's tree begins: the root, or the link behind
 * a floating joint. Without the second along the longest movable chain, that with most links of those with as many
 * joints, and then the first in the file; up to a joint that is held with none that moves behind it or, where an arm
 * cannot have all joints, up to where it has to end.
 * What choice.holds names, what follows another joint by <mimic>, and what has nothing of mass on it does not move.
 * Throws input_error. */
urdf_chain choose_chain(const urdf_model &model, const urdf_choice &choice);

/* Where a joint stands as long as nothing moves it, rad or m: at 0 or, where its range excludes that, in the middle
 * of it; where it moves, at the end of its range that is nearest to 0. */
double resting_value(const urdf_model &model, const urdf_joint &joint, bool moves);

/* For each of model.joints(): what choice.holds says, what <mimic> makes of the joint that it follows, or
 * resting_value(). A joint that follows none that there is goes with a warning. Throws input_error. */
std::vector<double> held_values(const urdf_model &model, const urdf_choice &choice,
                                const std::vector<std::size_t> &moving, std::vector<std::string> &warnings);

} // namespace berth

#endif
