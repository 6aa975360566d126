/* How well the loop keeps time, measured in every run at the price of a few additions a tick. */
#ifndef HAL_LINUX_LOOP_TIMING_H
#define HAL_LINUX_LOOP_TIMING_H

#include <cstdint>
#include <string>
#include <vector>

#include "options.h"

namespace berth
{

/* Bins of 1 us; what is below 0 counts in the first. All memory is taken at the start. */
class time_histogram
{
  public:
    void add(std::int64_t time_ns)
    {
        const std::int64_t bin = time_ns < 0 ? 0 : time_ns / bin_ns;
        if (bin < bin_count) {
            counts_[static_cast<std::size_t>(bin)]++;
        }
        min_ns_ = count_ == 0 || time_ns < min_ns_ ? time_ns : min_ns_;
        max_ns_ = count_ == 0 || time_ns > max_ns_ ? time_ns : max_ns_;
        sum_ns_ += static_cast<double>(time_ns);
        count_++;
    }

    std::uint64_t count() const { return count_; }
    double min_us() const { return 1e-3 * static_cast<double>(min_ns_); }
    double max_us() const { return 1e-3 * static_cast<double>(max_ns_); }
    double mean_us() const { return count_ == 0 ? 0.0 : 1e-3 * sum_ns_ / static_cast<double>(count_); }

    /* Upper edge of the bin that the share of all times lies in or below; beyond the bins, the largest time. */
    double percentile_us(double share) const;

    const std::vector<std::uint32_t> &counts() const { return counts_; } /* by whole us */

  private:
    static constexpr std::int64_t bin_ns = 1000;
    static constexpr std::int64_t bin_count = 20000;

    std::vector<std::uint32_t> counts_ = std::vector<std::uint32_t>(bin_count);
    std::uint64_t count_ = 0;
    std::int64_t min_ns_ = 0;
    std::int64_t max_ns_ = 0;
    double sum_ns_ = 0.0;
};

struct loop_timing {
    time_histogram wake_up;      /* wake-up after the instant that was asked for */
    time_histogram execution;    /* wake-up to the next wait */
    time_histogram tick_to_wire; /* tick to the driver's confirmation of the setpoint */
    time_histogram force_age;    /* of the force that a tick uses: its receive stamp to the wake-up */
    std::uint64_t overruns = 0;  /* whole periods skipped */
};

struct timing_setting {
    std::string command_line;
    std::string real_time; /* how the loop is scheduled */
    std::int64_t cpu;
    std::int64_t priority; /* 0: SCHED_OTHER */
    std::int64_t interval_us;
    std::string start_time;
};

/* cyclictest's --json layout, with wake-up as its latency and the others beside it. Throws input_error. */
void write_timing(const std::string &path, const loop_timing &timing, const timing_setting &setting);

/* Five lines for a person. */
void print_timing(const loop_timing &timing);

} // namespace berth

#endif
