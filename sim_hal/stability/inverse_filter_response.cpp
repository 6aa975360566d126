#include "inverse_filter_response.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "../../firmware/inverse_filter.h"
#include "../../firmware/pi.h"

namespace berth
{

namespace
{

constexpr int band_steps = 100;
using complex = std::complex<double>;

complex filter_response(const inverse_filter &filter, double frequency_Hz, double period_s)
{
    if (!filter.enabled) {
        return 1.0;
    }
    const complex z1 = std::polar(1.0, -2.0 * pi * frequency_Hz * period_s);
    return (filter.b[0] + z1 * (filter.b[1] + z1 * filter.b[2])) / (1.0 + z1 * (filter.a[0] + z1 * filter.a[1]));
}

complex robot_response(const robot_rig &robot, double frequency_Hz)
{
    const complex s(0.0, frequency_Hz / robot.transfer_frequency_Hz);
    return 1.0 / (s * s + 2.0 * robot.transfer_damping_ratio * s + 1.0);
}

/* Root of the summed squares of the impulse response. */
double noise_gain(inverse_filter filter)
{
    constexpr int samples = 20000;
    inverse_filter_rest_at(&filter, 0.0);
    double sum = 0.0;
    for (int i = 0; i < samples; i++) {
        const double h = inverse_filter_step(&filter, i == 0 ? 1.0 : 0.0);
        sum += h * h;
    }
    return std::sqrt(sum);
}

} // namespace

inverse_filter_response respond(const rig &rig)
{
    const double period_s = config_period_s(&rig.firmware);
    inverse_filter filter;
    inverse_filter_start(&filter, &rig.firmware);
    inverse_filter_response response{0.0, 0.0, 0.0, noise_gain(filter)};
    for (int i = 0; i <= band_steps; i++) {
        const double f = corrected_band_Hz * i / band_steps;
        const double robot = std::abs(robot_response(rig.robot, f));
        const double both = robot * std::abs(filter_response(filter, f, period_s));
        response.amplitude_error_without = std::max(response.amplitude_error_without, std::abs(robot - 1.0));
        response.amplitude_error_with = std::max(response.amplitude_error_with, std::abs(both - 1.0));
    }
    response.phase_deg = std::arg(filter_response(filter, corrected_band_Hz, period_s)) * 180.0 / pi;
    return response;
}

} // namespace berth
