/* How far a parameter of the rig can go until the loop turns unstable, or stable. */
#ifndef SIM_HAL_STABILITY_LIMITS_H
#define SIM_HAL_STABILITY_LIMITS_H

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "../../hal/rig/rig.h"
#include "physical_parameter.h"
#include "spectrum.h"

namespace berth
{

/* A value of the parameter at which the loop changes between stable and unstable. */
struct stability_limit {
    double value;
    bool stable_above; /* stable just above, unstable just below */
    std::string jump;  /* why |z| jumps past 1; empty: it passes through */
    berth::mode mode;  /* the one that goes, just on the unstable side */
    std::string mode_name;
    bool is_rough = false; /* `value` tells no more than the order of magnitude, see `jump` */
};

/* An end of the range that was searched counts as the end of an interval. */
struct stable_interval {
    double from;
    double to;
};

struct parameter_limits {
    std::string_view key; /* of the rig file */
    double value;         /* the rig's own */
    double from;          /* range searched: what a rig file permits of three decades to either side, delays one */
    double to;
    std::vector<stability_limit> limits; /* by rising value */
    std::vector<stable_interval> stable; /* by rising value */

    /* The same by the first-order formula for the slow mode. */
    std::vector<double> first_order_limits;

    /* What factors are reckoned from: the rig's own value, or a usual one of its kind where that is 0. */
    double centre = 0.0;

    /* Nearest to the rig's own value; nullptr: none in the range. */
    const stability_limit *nearest_below() const;
    const stability_limit *nearest_above() const;
    std::optional<double> first_order_below() const;
    std::optional<double> first_order_above() const;
};

/* How a parameter is scanned: from grid point to grid point by this share of the value (and of a period, for
 * delays), up to this factor either way (delays: 10 at most). Stable intervals narrower than a step may be
 * overlooked. */
struct scan {
    double step;
    double share_of_period;
    double factor;
};
constexpr scan fine_scan{0.005, 0.05, 1e3};
constexpr scan scan_of_harmonics{0.04, 0.25, 1e3}; /* each value has harmonics to be balanced */
constexpr scan scan_of_slow_ones{0.1, 1.0, 10.0};  /* each value takes milliseconds */

/* The linear loop of a rig: the rig itself, or what is equivalent to it at an amplitude. */
using linear_view = std::function<rig(const rig &)>;
inline rig as_it_is(const rig &rig)
{
    return rig;
}

/* All else stays as it is; damping ratios that the rig names stay, too. */
parameter_limits find_limits(const rig &rig, std::string_view key, const linear_view &linear = as_it_is,
                             const scan &how = fine_scan);

/* The stable parts of from..to, by rising value; parts narrower than the step of `fine_scan` of `to` may be
 * overlooked. */
std::vector<stable_interval> stable_within(const rig &rig, std::string_view key, double from, double to,
                                           const linear_view &linear = as_it_is);

/* How many ms longer the robot's dead time may be; nothing: no limit within ten times its length, or the loop is
 * unstable as it is. */
std::optional<double> dead_time_margin_ms(const rig &rig, const parameter_limits &dead_time,
                                          const linear_view &linear = as_it_is);

/* A rate of the loop, everything else as it is. */
struct rate_verdict {
    double rate_Hz;
    std::string refusal; /* why no rig may have it; empty: it may */
    bool is_stable = false;
};

/* Common rates that divide 1e9, and the rig's own. */
std::vector<rate_verdict> judge_rates(const rig &rig, delays_stay delays, const linear_view &linear = as_it_is);

} // namespace berth

#endif
