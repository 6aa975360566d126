/* How late the loop wakes: a histogram as `cyclictest --json=FILE --histogram=US` writes it, and draws from it.
 *
 * A tick that wakes late reads what has arrived by then, so it may catch a newer force, and its setpoint leaves and
 * is passed as much later. The manipulator does not notice: its step is the period, always. */
#ifndef SIM_HAL_HIL_WAKE_HISTOGRAM_H
#define SIM_HAL_HIL_WAKE_HISTOGRAM_H

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "../../hal/rig/rig.h"
#include "random.h"

namespace berth
{

struct wake_histogram {
    std::vector<std::int64_t> lateness_ns; /* rising; empty: the loop is never late */
    std::vector<double> share;             /* of wake-ups up to this lateness; the last is 1 */
    double wakes = 0.0;                    /* counted in it */
    double left_out = 0.0;                 /* later than the histogram reaches: cycles that it does not count */
    double mean_ns = 0.0;

    std::int64_t max_ns() const { return lateness_ns.empty() ? 0 : lateness_ns.back(); }
};

/* {"thread": {"0": {"histogram": {"8": 120, "9": 77}, "cycles": 197}}}: lateness in us (in ns with
 * "resolution_in_ns": 1) to wake-ups; threads are added up and other keys ignored. Throws input_error. */
wake_histogram parse_wake_histogram(std::string_view text, const std::string &origin);

/* The file that run.lateness_file names, empty if none; throws input_error if it does not fit the rig's period. */
wake_histogram load_wake_histogram(const rig &rig);

/* Says how many wake-ups the histogram left out; empty if it has all. */
std::string left_out_note(const wake_histogram &histogram);

/* A wake-up a period late would miss a tick. */
bool fits_period(const wake_histogram &histogram, const rig &rig);

/* One lateness a tick. */
class wake_lateness
{
  public:
    wake_lateness(wake_histogram histogram, std::int64_t seed);

    std::int64_t next_ns();

  private:
    wake_histogram histogram_;
    random_stream random_;
};

} // namespace berth

#endif
