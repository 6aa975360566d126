/* Values of a rig that hardware or the method hardly has: slips of the keyboard, wrong units, and loops that no
 * verdict can make useful. Each finding names the key, what is odd and what to do. */
#ifndef SIM_HAL_PLAUSIBILITY_H
#define SIM_HAL_PLAUSIBILITY_H

#include <string>
#include <vector>

#include "../hal/rig/rig.h"

namespace berth
{

struct implausible_value {
    std::string key;
    std::string what; /* the value, and what it leads to */
    std::string why;  /* the threshold and its origin */
    std::string advice;
};

/* The run ends before its object is gripped: it never closes the loop. */
bool never_grips(const rig &rig);

/* Empty: nothing is odd. Of a rig that has been checked; an arm's own keys are not looked at. */
std::vector<implausible_value> implausible_values(const rig &rig);

} // namespace berth

#endif
