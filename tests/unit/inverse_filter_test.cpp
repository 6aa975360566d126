#include <doctest/doctest.h>

#include <cmath>
#include <complex>

#include "../../firmware/pi.h"
#include "firmware/inverse_filter.h"
#include "seeded.h"

namespace
{

app_config filter_config(double frequency_Hz, double damping_ratio, double bandwidth_Hz = 40.0)
{
    app_config config = config_default();
    config.inverse_filter = {1, frequency_Hz, damping_ratio, bandwidth_Hz};
    REQUIRE(config_validate(&config).key == nullptr);
    return config;
}

/* |G_R| of the robot, from its definition. */
double robot_amplitude(const inverse_filter_config &robot, double frequency_Hz)
{
    const double r = frequency_Hz / robot.robot_frequency_Hz;
    return 1.0 / std::abs(std::complex<double>(1.0 - r * r, 2.0 * robot.robot_damping_ratio * r));
}

/* Amplitude of the filter's answer to a sine, by correlation over whole periods after the transient has died. */
double measured_amplitude(const app_config &config, double frequency_Hz)
{
    inverse_filter filter;
    inverse_filter_start(&filter, &config);
    const double w = 2.0 * berth::pi * frequency_Hz * config_period_s(&config);
    const int settle_ticks = 2 * static_cast<int>(config.loop.rate_Hz);
    const int measured_ticks = 10 * static_cast<int>(config.loop.rate_Hz); /* frequencies in steps of 0.1 Hz */
    std::complex<double> sum = 0.0;
    for (int n = -settle_ticks; n < measured_ticks; n++) {
        const double output_m = inverse_filter_step(&filter, std::sin(w * n));
        if (n >= 0) {
            sum += output_m * std::polar(1.0, -w * n);
        }
    }
    return 2.0 * std::abs(sum) / measured_ticks;
}

} // namespace

TEST_CASE("inverse_filter: filter and robot together are a Butterworth filter of the bandwidth up to 5 Hz")
{
    double worst_without = 0.0, worst_with = 0.0;
    for (const double robot_Hz : {8.0, 12.0, 20.0}) {
        for (const double damping_ratio : {0.3, 0.7, 1.0}) {
            const app_config config = filter_config(robot_Hz, damping_ratio);
            for (int i = 1; i <= 10; i++) {
                const double frequency_Hz = 0.5 * i;
                CAPTURE(robot_Hz);
                CAPTURE(damping_ratio);
                CAPTURE(frequency_Hz);
                const double robot = robot_amplitude(config.inverse_filter, frequency_Hz);
                const double both = robot * measured_amplitude(config, frequency_Hz);
                const double butterworth = 1.0 / std::sqrt(1.0 + std::pow(frequency_Hz / 40.0, 4.0));
                CHECK(std::fabs(both - butterworth) <= 5e-6); /* left over: poles matched, not the continuous ones */
                worst_without = std::fmax(worst_without, std::fabs(robot - 1.0));
                worst_with = std::fmax(worst_with, std::fabs(both - 1.0));
            }
        }
    }
    CHECK(worst_without > 0.39);
    CHECK(worst_with <= 1.3e-4);
}

TEST_CASE("inverse_filter: noise above the band rises by (bandwidth/robot)^2 and no more")
{
    const app_config config = filter_config(12.0, 0.5);
    const double ratio = 40.0 / 12.0;
    const double near_nyquist = measured_amplitude(config, 199.0);
    CHECK(near_nyquist > 0.8 * ratio * ratio);
    CHECK(near_nyquist < 1.2 * ratio * ratio);
}

TEST_CASE("inverse_filter: a constant position passes with gain one")
{
    app_config config = filter_config(12.0, 0.1);
    config.manipulator.initial_position_m = 0.3;
    inverse_filter filter;
    inverse_filter_start(&filter, &config);
    for (int i = 0; i < 400; i++) {
        REQUIRE(std::fabs(inverse_filter_step(&filter, 0.3) - 0.3) <= 1e-12); /* from the first tick on */
    }
    double output_m = 0.0;
    for (int i = 0; i < 400; i++) {
        output_m = inverse_filter_step(&filter, -0.7);
    }
    CHECK(std::fabs(output_m + 0.7) <= 1e-12);
    inverse_filter_rest_at(&filter, 0.9);
    CHECK(std::fabs(inverse_filter_step(&filter, 0.9) - 0.9) <= 1e-12);
}

TEST_CASE("inverse_filter: passes through bit for bit when it is not enabled")
{
    SEEDED(random, "inverse_filter:*");
    const app_config config = config_default();
    inverse_filter filter;
    inverse_filter_start(&filter, &config);
    int changed = 0;
    for (int i = 0; i < 1000; i++) {
        const double wanted_m = seeded::uniform(random, -1.0, 1.0);
        changed += inverse_filter_step(&filter, wanted_m) != wanted_m;
    }
    CHECK(changed == 0);
}
