#include <algorithm>
#include <cmath>

#include "about_mean.h"
#include "block_search.h"
#include "floor.h"

namespace berth
{

void block_search::withdraw_what_follows_nothing(block_diagnosis &result)
{
    constexpr double as_well = 1.1; /* times the error */
    if (found_.empty() || model_.which() == block::manipulator) {
        return; /* a manipulator that sticks has a cause that holds it */
    }
    if (rms_about_mean(model_) < as_well * rms_of(error_left(), model_.uses(), row_use::fit)) {
        follows_nothing_ = true;
        found_.clear();
        result.causes.clear();
        result.alternatives.clear();
        incumbent_ = base_;
        incumbent_.rig = retuned_;
        find_what_is_left();
    }
}

bool block_search::holds_zero(const remains &)
{
    return std::any_of(found_.begin(), found_.end(), [&](const effect *known) {
        const std::string_view size = known->parameters[0].key;
        for (std::size_t i = 0; i < incumbent_.ci95.size(); i++) {
            if (incumbent_.parameters[i].key->path == size && value_of(given_, size) == 0.0 &&
                std::abs(value_of(incumbent_.rig, size)) < incumbent_.ci95[i]) {
                return true;
            }
        }
        return false;
    });
}

} // namespace berth
