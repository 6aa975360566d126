/* What a person watches of a running loop: a few fields of the log, thinned, one JSON object a sample. The target
 * sends them as datagrams, the host makes them of a log or a simulated run; whoever reads them cannot tell which.
 *
 *     {"berth_live":1,"rig":"ess","config_hash":"...","period_ms":2.5,"run":7,"sequence":0,"time_s":0.0075, ...}
 *
 * Names and units are those of the log (firmware/recorder.h), with these exceptions: `run` tells one run from the
 * next, `sequence` counts samples, `unsent` those that the network did not take, `missed_ticks` the missed ticks in
 * all, `peak_force_N` is the largest measured force since the sample before, `limits` all that acted since then. */
#ifndef HAL_LIVE_SAMPLE_H
#define HAL_LIVE_SAMPLE_H

#include <cstdint>
#include <string>

#include "../firmware/recorder.h"

namespace berth
{

constexpr double live_rate_Hz = 100.0; /* at most; enough for 10 samples a swing of 10 Hz */

struct live_source {
    std::string rig;
    std::string config_hash;
    std::int64_t period_ns;
    std::uint32_t run;
};

class live_thinner
{
  public:
    explicit live_thinner(const live_source &source, double rate_Hz = live_rate_Hz);

    /* Takes one tick. True: a sample is due, which json() makes. */
    bool add(const tick_record &record);

    /* The sample of the last tick. `unsent`: samples before that did not get out. */
    std::string json(std::uint64_t unsent);

  private:
    std::string begin_; /* what all samples have in common */
    std::int64_t stride_ticks_;
    std::int64_t ticks_ = 0; /* since the last sample */
    std::uint64_t sequence_ = 0;
    std::uint64_t missed_ticks_ = 0;
    double peak_force_N_ = 0.0;
    std::uint32_t limits_ = 0;
    tick_record last_{};
};

} // namespace berth

#endif
