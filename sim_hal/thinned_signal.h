/* A signal of any length in a bounded number of samples: when there are too many, two become one, and from then on
 * each sample stands for twice as many ticks. */
#ifndef SIM_HAL_THINNED_SIGNAL_H
#define SIM_HAL_THINNED_SIGNAL_H

#include <cstddef>
#include <vector>

namespace berth
{

enum class thinning {
    first,   /* the first of those that become one: a plain signal of fewer samples */
    largest, /* the largest: no peak is lost */
};

class thinned_signal
{
  public:
    /* `samples_max`: even. */
    thinned_signal(thinning how, std::size_t samples_max) : how_(how), samples_max_(samples_max) {}

    void add(double value);
    void clear();

    const std::vector<double> &values() const { return values_; }
    std::size_t stride() const { return stride_; } /* ticks for which each sample stands */
    std::size_t added() const { return added_; }   /* ticks in all, those of an open sample included */

  private:
    double one_of(double earlier, double later) const;
    void halve();

    thinning how_;
    std::size_t samples_max_;
    std::size_t stride_ = 1;
    std::size_t added_ = 0;
    double open_ = 0.0; /* of the ticks since the last whole sample */
    std::vector<double> values_;
};

} // namespace berth

#endif
