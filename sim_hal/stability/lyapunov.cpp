#include "lyapunov.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "../../hal/rig/rig_file.h"
#include "dominant_root.h"

namespace berth
{

namespace
{

constexpr double ticks_least = 20000.0;
constexpr double duration_least_s = 50.0;
constexpr std::int64_t ticks_most = 640000;
constexpr std::int64_t phase_cycles_least = 8;

/* The largest eigenvalue that the loop would have if it did not change. */
std::complex<double> steady_eigenvalue(const rig &rig)
{
    dominant_root_finder finder;
    finder.spectral_radius(make_loop_equation(without_variation(rig)));
    return finder.dominant_eigenvalue();
}

/* Height of an oscillation from two successive positions: a z^n seen from both sides, without the swing. Of the loop
 * that does not change it is exactly |a| |z|^n. */
class swing_height
{
  public:
    explicit swing_height(std::complex<double> z) : magnitude_(std::abs(z)), cosine_(std::cos(std::arg(z)))
    {
        constexpr double least_sine2 = 1e-8; /* a mode that does not swing has no height but its position */
        sine2_ = std::max(1.0 - cosine_ * cosine_, least_sine2);
        cosine_ = 1.0 - cosine_ * cosine_ < least_sine2 ? 0.0 : cosine_;
        sine2_ = cosine_ == 0.0 ? 1.0 : sine2_;
    }
    double squared(double position_m, double before_m) const
    {
        const double turned_m = before_m * magnitude_;
        const double side_m = position_m - turned_m * cosine_;
        return side_m * side_m / sine2_ + turned_m * turned_m;
    }

  private:
    double magnitude_;
    double cosine_;
    double sine2_;
};

/* Logarithm of the disturbance's height at each tick. */
void find_heights(const rig &rig, const loop_timeline &timeline, transition_cache &cache,
                  std::vector<double> &logarithms)
{
    constexpr int shaken_ticks = 16; /* stirs fast modes, too */
    constexpr double large2 = 1e200;
    const swing_height height(steady_eigenvalue(rig));
    linear_loop loop(rig, timeline, cache);
    random_stream random(0, stream_disturbance);
    logarithms.clear();
    double scaled_by = 0.0; /* logarithm */
    double before_m = 0.0;
    for (const timeline_step &step : timeline.steps) {
        if (step.what == timeline_step::kind::tick) {
            if (logarithms.size() < shaken_ticks) {
                loop.push(random.uniform() - 0.3);
            }
            const double height2 = height.squared(loop.position_m(), before_m);
            logarithms.push_back(0.5 * std::log(height2) + scaled_by);
            before_m = loop.position_m();
            if (height2 > large2 || height2 < 1.0 / large2) {
                const double factor = 1.0 / std::sqrt(height2);
                loop.scale(factor);
                before_m *= factor;
                scaled_by -= std::log(factor);
            }
        }
        loop.advance(step);
    }
}

/* Rises from 0 and falls back to it with all its derivatives: an average under it forgets what swings and how the
 * sequence begins and ends (Das, Sander, Saiki and Yorke 2017). */
double bump(double share)
{
    return share <= 0.0 || share >= 1.0 ? 0.0 : std::exp(-0.25 / (share * (1.0 - share)));
}

/* Slope in 1/tick of `count` steps of the logarithms under the bump. */
double slope_under_bump(const double *logarithms, std::size_t count)
{
    double weights = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < count; i++) {
        const double weight = bump((static_cast<double>(i) + 0.5) / static_cast<double>(count));
        weights += weight;
        sum += weight * (logarithms[i + 1] - logarithms[i]);
    }
    return sum / weights;
}

/* Slope in 1/tick after the first eighth, and half its 95 % interval from the scatter of the slopes of its parts. */
lyapunov_exponent average_slope(const std::vector<double> &logarithms)
{
    constexpr std::size_t parts = 20;
    constexpr double student95 = 2.093; /* of 19 degrees of freedom */
    const std::size_t first = logarithms.size() / 8;
    const std::size_t part = (logarithms.size() - 1 - first) / parts;
    const double *const from = logarithms.data() + first;
    const double mean = slope_under_bump(from, part * parts);
    double scatter2 = 0.0;
    for (std::size_t p = 0; p < parts; p++) {
        const double difference = slope_under_bump(from + p * part, part) - mean;
        scatter2 += difference * difference / (parts - 1);
    }
    return {mean, student95 * std::sqrt(scatter2 / parts), static_cast<std::int64_t>(logarithms.size())};
}

/* Ticks in which a free clock drifts through a period; 0 if it does not. */
double ticks_of_a_phase_cycle(const rig &rig)
{
    return rig.robot.clock == robot_clock::free && rig.robot.clock_drift_ppm != 0.0
               ? 1e6 / std::abs(rig.robot.clock_drift_ppm)
               : 0.0;
}

} // namespace

lyapunov_exponent exponent_finder::along(const rig &rig, const loop_timeline &timeline)
{
    find_heights(rig, timeline, cache_, logarithms_);
    lyapunov_exponent found = average_slope(logarithms_);
    found.growth_per_s /= config_period_s(&rig.firmware);
    found.ci95_per_s /= config_period_s(&rig.firmware);
    return found;
}

lyapunov_exponent exponent_of(const rig &rig, const wake_histogram &histogram, std::int64_t ticks)
{
    exponent_finder finder;
    if (ticks > 0) {
        return finder.along(rig, make_timeline(rig, histogram, ticks));
    }
    const double drifting = static_cast<double>(phase_cycles_least) * ticks_of_a_phase_cycle(rig);
    ticks = std::llround(std::max({ticks_least, duration_least_s * rig.firmware.loop.rate_Hz,
                                   std::min(drifting, static_cast<double>(ticks_most))}));
    for (;; ticks *= 2) {
        const lyapunov_exponent found = finder.along(rig, make_timeline(rig, histogram, ticks));
        if (found.ci95_per_s <= std::max(0.01 * std::abs(found.growth_per_s), 1e-3) || 2 * ticks > ticks_most) {
            return found;
        }
    }
}

} // namespace berth
