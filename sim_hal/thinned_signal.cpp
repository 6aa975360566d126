#include "thinned_signal.h"

#include <algorithm>

namespace berth
{

double thinned_signal::one_of(double earlier, double later) const
{
    return how_ == thinning::first ? earlier : std::max(earlier, later);
}

void thinned_signal::add(double value)
{
    open_ = added_ % stride_ == 0 ? value : one_of(open_, value);
    added_++;
    if (added_ % stride_ == 0) {
        values_.push_back(open_);
    }
    if (values_.size() > samples_max_) {
        halve();
    }
}

void thinned_signal::clear()
{
    values_.clear();
    stride_ = 1;
    added_ = 0;
}

/* There is one sample more than the even number: it stays open, and `added_` counts its ticks. */
void thinned_signal::halve()
{
    open_ = values_.back();
    for (std::size_t i = 0; i + 1 < values_.size(); i += 2) {
        values_[i / 2] = one_of(values_[i], values_[i + 1]);
    }
    values_.resize(values_.size() / 2);
    stride_ *= 2;
}

} // namespace berth
