#include "sensor_ringing.h"

#include <algorithm>
#include <cmath>

#include "../noise/noise.h"

namespace berth
{

namespace
{

constexpr double never_changes_N = 1e-200; /* a force without noise and steps: nothing says what is heard */

} // namespace

sensor_ringing::sensor_ringing(const rig &rig, const record &record)
    : record_(record), on_the_way_s_(1e-3 * rig.robot.dead_time_ms),
      decay_per_s_(rig.sensor.damping_ratio * std::sqrt(rig.sensor.stiffness_N_per_m / rig.object.mass_kg)),
      stiffness_N_per_m_(rig.sensor.stiffness_N_per_m),
      swing_N_s_per_m_(std::sqrt(rig.sensor.stiffness_N_per_m * rig.object.mass_kg))
{
    constexpr double heard = 0.1; /* of the noise */
    heard_N_ = heard * rms_of_noise_and_rounding(record.force_N);
}

double sensor_ringing::dies_away_s(const record_segment &part) const
{
    const double swing_N = swing_N_s_per_m_ * fastest_m_per_s(part);
    return heard_N_ > never_changes_N && swing_N > heard_N_
               ? std::log(swing_N / heard_N_) / std::max(decay_per_s_, 1e-3)
               : 0.0;
}

double sensor_ringing::forgets_s(double off_m) const
{
    const double heard_N = std::max(heard_N_, never_changes_N);
    return std::max(to_a_twentieth_s(),
                    std::log(stiffness_N_per_m_ * off_m / heard_N) / std::max(decay_per_s_, 1.0));
}

/* As long as the robot still does what it was told before: it stands in the replay, and then sets out at that. */
double sensor_ringing::fastest_m_per_s(const record_segment &part) const
{
    constexpr double soon_s = 0.01;
    const std::vector<double> &x =
        record_.command_position_m.empty() ? record_.robot_position_m : record_.command_position_m;
    const auto rows = static_cast<std::size_t>(std::ceil(soon_s / record_.period_s));
    const auto until = std::min(
        part.end,
        part.begin + rows + static_cast<std::size_t>(std::ceil(std::max(soon_s, on_the_way_s_) / record_.period_s)));
    double fastest_m_per_s = 0.0;
    for (std::size_t n = part.begin; n + rows < until; n++) {
        fastest_m_per_s =
            std::max(fastest_m_per_s, std::abs(x[n + rows] - x[n]) / (static_cast<double>(rows) * record_.period_s));
    }
    return fastest_m_per_s;
}

} // namespace berth
