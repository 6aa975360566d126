#include "gain_limit.h"

#include <algorithm>

#include "../../hal/rig/keys.h"
#include "../stability/spectrum.h"

namespace berth
{

namespace
{

constexpr int steps_to_one = 50;
constexpr double precision = 1e-4;

} // namespace

rig with_feedback_gain(const rig &whole, double gain)
{
    static const rig_key *const key = find_key("sensor.gain_error");
    rig part = whole;
    double &error = part.effect_values[key->effect_value];
    error = gain * (1.0 + error) - 1.0;
    part.firmware.hardware.sensor_gain = 1.0 + error;
    return part;
}

double least_damping_ratio(const rig &rig)
{
    double least = 1.0;
    for (const mode &mode : loop_spectrum(rig).modes) {
        if (std::abs(mode.z) > 0.0) {
            least = std::min(least, mode.damping_ratio);
        }
    }
    return least;
}

std::optional<double> gain_limit(const std::function<double(double)> &damping, double margin, double most)
{
    double safe = 0.0;
    for (int i = 1; i <= steps_to_one; i++) {
        const double gain = most * i / steps_to_one;
        if (!(damping(gain) < margin)) {
            safe = gain;
            continue;
        }
        double low = safe;
        double high = gain;
        while (high - low > precision) {
            const double middle = 0.5 * (low + high);
            (damping(middle) < margin ? high : low) = middle;
        }
        return low;
    }
    return {};
}

} // namespace berth
