#include "calibration.h"

namespace berth
{

std::string calibration_for(const effect *a, const effect *b)
{
    const effect *surest = nullptr;
    for (const effect *const one : {a, b}) {
        if (one != nullptr && !one->calibration.what.empty() &&
            (surest == nullptr || one->calibration.rank < surest->calibration.rank)) {
            surest = one;
        }
    }
    if (surest != nullptr) {
        return std::string(surest->calibration.what);
    }
    const effect *const told = a != nullptr ? a : b;
    return told == nullptr ? "" : "measure " + std::string(told->parameters[0].key) + " by itself";
}

} // namespace berth
