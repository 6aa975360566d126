/* A manipulator of 1 Hz and an object of 5 Hz: with the paper's dead time far beyond its limit. */
#ifndef TESTS_SUPPORT_STIFF_OBJECT_H
#define TESTS_SUPPORT_STIFF_OBJECT_H

#include <string>
#include <vector>

namespace berth
{

inline const std::vector<std::string> stiff_object{"object.stiffness_N_per_m=60000", "object.damping_N_s_per_m=150"};

} // namespace berth

#endif
