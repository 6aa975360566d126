#include "../support/far_side.h"

namespace berth
{

struct far_side::process {
};

far_side::far_side(const std::string & /*rig*/) {}
far_side::~far_side() = default;

} // namespace berth
