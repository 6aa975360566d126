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
        withdraw(result);
    }
}

/* Behind a robot's fault that switches, each instant that is off is an error in a stiff contact, and some cause
 * lowers it: one whose size may be none beside what is left is not told. */
void block_search::withdraw_what_may_be_none(block_diagnosis &result)
{
    const auto may_be_none = [&](const effect *known) {
        const std::string_view size = known->parameters[0].key;
        for (std::size_t i = 0; i < incumbent_.ci95.size(); i++) {
            if (incumbent_.parameters[i].key->path == size) {
                const double value = value_of(incumbent_.rig, size);
                const double without = value_of(given_, size);
                return std::abs(without < unlimited ? value - without : value) < incumbent_.ci95[i];
            }
        }
        return false;
    };
    if (result.verdict != verdict::partly_explained || input_.without_switching_fault == nullptr ||
        model_.which() != block::force || !std::all_of(found_.begin(), found_.end(), may_be_none)) {
        return;
    }
    withdraw(result);
    result.doubts.clear();
    verdict_of(result);
    result.verdict = verdict::unknown;
    result.refinable = refinable();
    result.doubts.emplace_back(
        "it lies behind a robot that switches, and beside it the size of a cause may be none");
}

void block_search::withdraw(block_diagnosis &result)
{
    found_.clear();
    result.causes.clear();
    result.alternatives.clear();
    incumbent_ = base_;
    incumbent_.rig = retuned_;
    find_what_is_left();
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
