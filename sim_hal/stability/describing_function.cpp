#include "describing_function.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "../../firmware/pi.h"
#include "../effects/active.h"
#include "../effects/setpoint_path.h"
#include "../hil/sensor.h"
#include "../solver/object_steps.h"

namespace berth
{

namespace
{

constexpr int steps_a_period = 2048; /* what turns with the motion turns up to a step late: 0.3 % */
constexpr int settling_periods = 2;  /* for what only remembers the last turn */

/* Ticks in a period of the sine, which is stretched a little to have a whole number of them. */
double ticks_in(const rig &rig, double w_rad_per_s)
{
    return std::max(4.0, std::round(two_pi / w_rad_per_s * rig.firmware.loop.rate_Hz));
}

struct first_harmonic {
    std::complex<double> gain;
    double mean;
};

/* Sines and cosines at the middles of a period's steps. */
const std::vector<std::complex<double>> &circle_of(int steps)
{
    static thread_local std::vector<std::complex<double>> circle; /* of the last period: most have as many steps */
    if (circle.size() != static_cast<std::size_t>(steps)) {
        circle.clear();
        for (int i = 0; i < steps; i++) {
            const double angle = two_pi * (i + 0.5) / steps;
            circle.emplace_back(std::sin(angle), std::cos(angle));
        }
    }
    return circle;
}

/* Periods whose harmonics differ by less are the same: what is driven has settled, and goes on so. */
constexpr double settled = 1e-10;

bool is_same(const first_harmonic &a, const first_harmonic &b)
{
    return std::abs(a.gain - b.gain) <= settled * std::abs(a.gain) &&
           std::abs(a.mean - b.mean) <= settled * std::abs(a.mean);
}

template <typename function>
first_harmonic drive_period(const sine &in, int steps, const function &respond)
{
    std::complex<double> sum = 0.0;
    double total = 0.0;
    for (const std::complex<double> &at : circle_of(steps)) {
        const double out = respond(in.mean + in.amplitude * at.real(), in.amplitude * at.imag());
        sum += out * at;
        total += out;
    }
    return {2.0 * sum / static_cast<double>(steps) / in.amplitude, total / steps};
}

/* What comes out of `respond(value, rate of change by angle)`: the mean of the last of the periods, or one period if
 * it has settled before. */
template <typename function>
first_harmonic drive(const sine &in, int steps, int settling, int averaged, const function &respond)
{
    first_harmonic sum{0.0, 0.0};
    first_harmonic before{0.0, 0.0};
    for (int period = 0; period < settling + averaged; period++) {
        const first_harmonic now = drive_period(in, steps, respond);
        if (period > 0 && is_same(now, before)) {
            return now;
        }
        before = now;
        if (period >= settling) {
            sum.gain += now.gain / static_cast<double>(averaged);
            sum.mean += now.mean / averaged;
        }
    }
    return sum;
}

} // namespace

std::complex<double> gain_of(motion_stage &stage, const sine &in)
{
    const double step_s = two_pi / in.w_rad_per_s / steps_a_period;
    stage.start(in.mean);
    return drive(in, steps_a_period, settling_periods, 1,
                 [&](double value, double) { return stage.advance(value, step_s); })
        .gain;
}

std::complex<double> setpoint_gain(const rig &original, const sine &in)
{
    constexpr int settling = 4; /* limits that wind up */
    const double ticks = ticks_in(original, in.w_rad_per_s);
    rig at_rate = original;
    at_rate.firmware.loop.rate_Hz = ticks * in.w_rad_per_s / two_pi;
    setpoint_path path(at_rate);
    path.start(in.mean);
    return drive(in, static_cast<int>(ticks), settling, 1, [&](double value, double) { return path.take(value); })
        .gain;
}

double sample_gain(const rig &original, double amplitude_N)
{
    rig quiet = original;
    quiet.sensor.noise_N = 0.0;
    quiet.sensor.bias_N = 0.0;
    for (const char *const key : {"sensor.spike_probability", "sensor.drift_N_per_s", "sensor.periodic_N"}) {
        set_number(quiet, key, 0.0);
    }
    sensor electronics(quiet);
    return drive({amplitude_N, 0.0, 1.0}, steps_a_period, 0, 1,
                 [&](double force_N, double) { return electronics.shown_N(force_N, 0.0); })
        .gain.real();
}

spring_and_damper force_of(force_stage &stage, const sine &position_m, double rest_m, double mass_kg)
{
    const double step_s = two_pi / position_m.w_rad_per_s / steps_a_period;
    stage.start({position_m.mean, position_m.mean - rest_m, 0.0, 0.0, 0.0, step_s / mass_kg});
    const first_harmonic found =
        drive(position_m, steps_a_period, settling_periods, 1, [&](double position, double by_angle) {
            const double rate_m_per_s = by_angle * position_m.w_rad_per_s;
            return stage.force_N({position, position - rest_m, rate_m_per_s, rate_m_per_s, 0.0, step_s / mass_kg},
                                 step_s);
        });
    return {found.gain.real(), found.gain.imag() / position_m.w_rad_per_s, found.mean};
}

robot_load load_of(const rig &rig, const sine &robot_m)
{
    constexpr int settling = 6; /* the object swings on the sensor's spring, and on its own */
    constexpr int averaged = 2;
    const double steps = ticks_in(rig, robot_m.w_rad_per_s) * cornered_steps_a_tick;
    const double step_s = two_pi / robot_m.w_rad_per_s / steps;
    object_steps object(rig);
    const object_steps::step_maps maps = object.make_maps(step_s);
    double before_m = robot_m.mean;
    object.start(rig, before_m, 0.0);
    const first_harmonic found =
        drive(robot_m, static_cast<int>(steps), settling, averaged, [&](double position, double) {
            object.advance(maps, step_s, {before_m, position}, 0.0);
            before_m = position;
            /* The robot's velocity is that of the middle of the step: half a step's acceleration is missing. */
            const double later_m_per_s =
                -0.5 * step_s * robot_m.w_rad_per_s * robot_m.w_rad_per_s * (position - robot_m.mean);
            const double spring_N = object.spring_N();
            return spring_N == 0.0 ? 0.0 : spring_N + rig.sensor_damping_N_s_per_m() * later_m_per_s;
        });
    return {found.gain, found.mean};
}

} // namespace berth
