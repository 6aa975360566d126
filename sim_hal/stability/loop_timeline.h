/* What happens when in a loop that changes from tick to tick: which force each tick uses, and between which
 * setpoints the robot is at each instant. Free clocks, jitter, late wake-ups, and losses shape it; masses and
 * springs do not, so one timeline serves every point of a map.
 *
 * It is what firmware and simulated rig do with the same seed: they run, and every setpoint and every sample that
 * they pass on is its own number. Noise, limits and what makes the supervisor stop a loop are left out. */
#ifndef SIM_HAL_STABILITY_LOOP_TIMELINE_H
#define SIM_HAL_STABILITY_LOOP_TIMELINE_H

#include <cstdint>
#include <string>
#include <vector>

#include "../../hal/rig/rig.h"
#include "../hil/wake_histogram.h"

namespace berth
{

/* Setpoints are numbered by their ticks from 1 on, samples from 1 on; number 0 stands for 0. */
struct timeline_step {
    enum class kind : std::uint8_t {
        tick,   /* uses sample `from`, sends the next setpoint */
        sample, /* the next one is taken */
        jump,   /* the reference jumps from setpoint `from` to setpoint `to` */
        travel  /* no event for duration_ns */
    };
    kind what;
    std::int32_t from; /* of a tick the sample, else the setpoints of the line that the reference is on */
    std::int32_t to;
    std::int64_t duration_ns;
    double share; /* of the way from `from` to `to` that is done at the start */
    double share_per_s;
};

struct loop_timeline {
    std::vector<timeline_step> steps; /* from the first tick on in which the loop runs */
    std::int64_t ticks = 0;
    std::int32_t first_setpoint = 0; /* number of the one that the first tick sends, and */
    std::int32_t first_sample = 0;   /* of the first sample taken: those before are 0 */
    std::int32_t memory = 1;         /* no number is needed when so many newer ones are there; a power of two */
};

/* Throws input_error if the loop never comes to run. */
loop_timeline make_timeline(const rig &rig, const wake_histogram &histogram, std::int64_t ticks);

/* True if the loop of the rig changes from tick to tick. */
bool is_time_varying(const rig &rig);

/* The effects that make it change, each in words. */
std::vector<std::string> what_varies(const rig &rig, const wake_histogram &histogram);

/* The same rig without them. */
rig without_variation(const rig &rig);

} // namespace berth

#endif
