#include <doctest/doctest.h>

#include <functional>
#include <string>
#include <vector>

#include "firmware/config.h"
#include "hal/hal.h"
#include "not_finite.h"

namespace
{

struct config_case {
    const char *key; /* expected */
    const char *what;
    std::function<void(app_config &)> spoil;
};

void enable_filter(app_config &c)
{
    c.inverse_filter = {1, 12.0, 0.5, 40.0};
}

/* A double that must be finite and above `lowest_bad`: one case for each way of being wrong. */
void add_positive(std::vector<config_case> &cases, const char *key,
                  const std::function<double &(app_config &)> &value, bool zero_is_bad)
{
    for (const double bad : {-1.0, not_a_number, infinity, -infinity}) {
        cases.push_back({key, "negative or not finite", [=](app_config &c) { value(c) = bad; }});
    }
    if (zero_is_bad) {
        cases.push_back({key, "zero", [=](app_config &c) { value(c) = 0.0; }});
    }
}

void add_finite(std::vector<config_case> &cases, const char *key, const std::function<double &(app_config &)> &value)
{
    for (const double bad : {not_a_number, infinity, -infinity}) {
        cases.push_back({key, "not finite", [=](app_config &c) { value(c) = bad; }});
    }
}

std::vector<config_case> value_cases()
{
    using c = app_config;
    std::vector<config_case> cases;
    const auto positive = [&](const char *key, auto value) { add_positive(cases, key, value, true); };
    const auto non_negative = [&](const char *key, auto value) { add_positive(cases, key, value, false); };
    const auto finite = [&](const char *key, auto value) { add_finite(cases, key, value); };
    positive("manipulator.mass_kg", [](c &x) -> double & { return x.manipulator.mass_kg; });
    non_negative("manipulator.damping_N_s_per_m", [](c &x) -> double & { return x.manipulator.damping_N_s_per_m; });
    non_negative("manipulator.stiffness_N_per_m", [](c &x) -> double & { return x.manipulator.stiffness_N_per_m; });
    finite("manipulator.initial_position_m", [](c &x) -> double & { return x.manipulator.initial_position_m; });
    finite("manipulator.initial_velocity_m_per_s",
           [](c &x) -> double & { return x.manipulator.initial_velocity_m_per_s; });
    positive("operator.position_limit_m", [](c &x) -> double & { return x.operator_command.position_limit_m; });
    positive("operator.velocity_limit_m_per_s",
             [](c &x) -> double & { return x.operator_command.velocity_limit_m_per_s; });
    positive("operator.force_limit_N", [](c &x) -> double & { return x.operator_command.force_limit_N; });
    positive("operator.stale_after_ms", [](c &x) -> double & { return x.operator_command.stale_after_ms; });
    positive("sensor_channel.force_limit_N", [](c &x) -> double & { return x.sensor_channel.force_limit_N; });
    positive("sensor_channel.stale_after_ms", [](c &x) -> double & { return x.sensor_channel.stale_after_ms; });
    positive("robot_channel.stale_after_ms", [](c &x) -> double & { return x.robot_channel.stale_after_ms; });
    positive("robot_channel.unsent_after_ms", [](c &x) -> double & { return x.robot_channel.unsent_after_ms; });
    positive("robot_channel.start_tolerance_m", [](c &x) -> double & { return x.robot_channel.start_tolerance_m; });
    finite("limits.position_min_m", [](c &x) -> double & { return x.limits.position_min_m; });
    finite("limits.position_max_m", [](c &x) -> double & { return x.limits.position_max_m; });
    positive("limits.velocity_m_per_s", [](c &x) -> double & { return x.limits.velocity_m_per_s; });
    positive("limits.acceleration_m_per_s2", [](c &x) -> double & { return x.limits.acceleration_m_per_s2; });
    return cases;
}

const std::vector<config_case> relation_cases = {
    {"operator.position_limit_m", "at the end of the frame",
     [](app_config &c) { c.operator_command.position_limit_m = 2.1; }},
    {"operator.velocity_limit_m_per_s", "at the end of the frame",
     [](app_config &c) { c.operator_command.velocity_limit_m_per_s = 8.3; }},
    {"operator.force_limit_N", "at the end of the frame",
     [](app_config &c) { c.operator_command.force_limit_N = 54000.0; }},
    {"limits.position_max_m", "beyond the setpoint frame", [](app_config &c) { c.limits.position_max_m = 5.5; }},
    {"limits.position_min_m", "beyond the setpoint frame", [](app_config &c) { c.limits.position_min_m = -5.5; }},
    {"loop.rate_Hz", "zero", [](app_config &c) { c.loop.rate_Hz = 0; }},
    {"loop.rate_Hz", "negative", [](app_config &c) { c.loop.rate_Hz = -400; }},
    {"loop.rate_Hz", "too high", [](app_config &c) { c.loop.rate_Hz = 2000000; }},
    {"loop.rate_Hz", "does not divide 1e9 ns", [](app_config &c) { c.loop.rate_Hz = 300; }},
    {"loop.rate_Hz", "has too few digits", [](app_config &c) { c.loop.rate_Hz = 83.333333; }},
    {"loop.rate_Hz", "not a number", [](app_config &c) { c.loop.rate_Hz = not_a_number; }},
    {"loop.rate_Hz", "infinite", [](app_config &c) { c.loop.rate_Hz = infinity; }},
    {"loop.missed_time_budget_ms", "negative", [](app_config &c) { c.loop.missed_time_budget_ms = -1.0; }},
    {"loop.missed_time_budget_ms", "too long", [](app_config &c) { c.loop.missed_time_budget_ms = 1.1e6; }},
    {"loop.missed_time_refill_s", "zero", [](app_config &c) { c.loop.missed_time_refill_s = 0.0; }},
    {"robot_channel.setpoint_stale_after_ms", "zero",
     [](app_config &c) { c.robot_channel.setpoint_stale_after_ms = 0.0; }},
    {"robot_channel.setpoint_stale_after_ms", "not a number",
     [](app_config &c) { c.robot_channel.setpoint_stale_after_ms = not_a_number; }},
    {"reflex.following_error_m", "zero", [](app_config &c) { c.reflex.following_error_m = 0.0; }},
    {"reflex.following_error_m", "not a number", [](app_config &c) { c.reflex.following_error_m = not_a_number; }},
    {"reflex.following_error_m", "a dead time of too many ticks",
     [](app_config &c) { c.hardware.setpoint_to_motion_ms = 2.5 * 1024; }},
    {"reflex.following_error_ms", "negative", [](app_config &c) { c.reflex.following_error_ms = -1.0; }},
    {"reflex.link_quality", "negative", [](app_config &c) { c.reflex.link_quality = -0.1; }},
    {"reflex.link_quality", "above 1", [](app_config &c) { c.reflex.link_quality = 1.1; }},
    {"reflex.link_quality_window_s", "zero", [](app_config &c) { c.reflex.link_quality_window_s = 0.0; }},
    {"reflex.dead_time_power_W", "zero", [](app_config &c) { c.reflex.dead_time_power_W = 0.0; }},
    {"reflex.dead_time_power_window_s", "zero", [](app_config &c) { c.reflex.dead_time_power_window_s = 0.0; }},
    {"reflex.growth_J", "zero", [](app_config &c) { c.reflex.growth_J = 0.0; }},
    {"manipulator.integrator", "below", [](app_config &c) { c.manipulator.integrator = -1; }},
    {"manipulator.integrator", "above", [](app_config &c) { c.manipulator.integrator = INTEGRATOR_COUNT; }},
    {"manipulator.substeps", "none", [](app_config &c) { c.manipulator.substeps = 0; }},
    {"manipulator.substeps", "too many", [](app_config &c) { c.manipulator.substeps = 1001; }},
    {"operator.interface", "below", [](app_config &c) { c.operator_command.interface = -1; }},
    {"operator.interface", "above", [](app_config &c) { c.operator_command.interface = OPERATOR_INTERFACE_COUNT; }},
    {"operator.bus", "below", [](app_config &c) { c.operator_command.bus = -1; }},
    {"operator.bus", "above", [](app_config &c) { c.operator_command.bus = HAL_BUS_COUNT; }},
    {"limits.position_min_m", "equal to the maximum", [](app_config &c) { c.limits.position_min_m = 1.0; }},
    {"limits.position_min_m", "above the maximum", [](app_config &c) { c.limits.position_min_m = 1.1; }},
    {"manipulator.initial_position_m", "below the range",
     [](app_config &c) { c.manipulator.initial_position_m = -1.001; }},
    {"manipulator.initial_position_m", "above the range",
     [](app_config &c) { c.manipulator.initial_position_m = 1.001; }},
    {"inverse_filter.enabled", "nothing to invert",
     [](app_config &c) { enable_filter(c), c.inverse_filter.robot_frequency_Hz = 0.0; }},
    {"inverse_filter.enabled", "undamped robot",
     [](app_config &c) { enable_filter(c), c.inverse_filter.robot_damping_ratio = 0.0; }},
    {"inverse_filter.bandwidth_Hz", "not above the robot",
     [](app_config &c) { enable_filter(c), c.inverse_filter.bandwidth_Hz = 12.0; }},
    {"inverse_filter.bandwidth_Hz", "not a number",
     [](app_config &c) { enable_filter(c), c.inverse_filter.bandwidth_Hz = not_a_number; }},
};

void check_cases(const std::vector<config_case> &cases)
{
    for (const config_case &expected : cases) {
        CAPTURE(std::string(expected.key));
        CAPTURE(std::string(expected.what));
        app_config config = config_default();
        expected.spoil(config);
        const config_error error = config_validate(&config);
        REQUIRE(error.key != nullptr);
        CHECK(std::string(error.key) == expected.key);
        CHECK(std::string(error.message).size() > 10);
    }
}

} // namespace

TEST_CASE("config: each value out of its range is refused under its key")
{
    check_cases(value_cases());
}

TEST_CASE("config: each relation that does not hold is refused under its key")
{
    check_cases(relation_cases);
}

TEST_CASE("config: the defaults and the ends of every range are accepted")
{
    const auto accepted = [](const std::function<void(app_config &)> &change) {
        app_config config = config_default();
        change(config);
        return config_validate(&config).key == nullptr;
    };
    CHECK(accepted([](app_config &) {}));
    for (const double rate_Hz : {1.0, 50.0, 250.0 / 3.0, 400.0, 512.0, 1000.0, 1e6}) {
        CAPTURE(rate_Hz);
        CHECK(accepted([=](app_config &c) { c.loop.rate_Hz = rate_Hz; }));
    }
    CHECK(accepted([](app_config &c) { c.loop.missed_time_budget_ms = 0.0; }));
    CHECK(accepted([](app_config &c) { c.manipulator.damping_N_s_per_m = c.manipulator.stiffness_N_per_m = 0.0; }));
    CHECK(accepted([](app_config &c) { c.manipulator.substeps = 1000; }));
    CHECK(accepted([](app_config &c) { c.manipulator.initial_position_m = c.limits.position_min_m; }));
    CHECK(accepted([](app_config &c) { c.manipulator.initial_position_m = c.limits.position_max_m; }));
    CHECK(accepted([](app_config &c) { c.robot_channel.setpoint_stale_after_ms = infinity; })); /* no echo */
    CHECK(accepted([](app_config &c) {
        c.reflex.following_error_m = c.reflex.dead_time_power_W = c.reflex.growth_J = infinity;
        c.reflex.link_quality = 0.0;
        c.hardware.setpoint_to_motion_ms = 1e6; /* nobody looks back at it */
    }));
    CHECK(accepted(enable_filter));
    CHECK(accepted([](app_config &c) { c.inverse_filter.bandwidth_Hz = -1.0; })); /* not enabled: not looked at */
}

TEST_CASE("config: the period is a whole number of nanoseconds")
{
    app_config config = config_default();
    CHECK(config_period_ns(&config) == 2500000);
    CHECK(config_period_s(&config) == 0.0025);
    config.loop.rate_Hz = 512;
    CHECK(config_period_ns(&config) == 1953125);
    CHECK(static_cast<double>(config_period_ns(&config)) * config.loop.rate_Hz == 1e9);
    config.loop.rate_Hz = 250.0 / 3.0;
    CHECK(config_period_ns(&config) == 12000000);
}

TEST_CASE("config: milliseconds become the nearest nanosecond")
{
    CHECK(ns_from_ms(0.0) == 0);
    CHECK(ns_from_ms(17.5) == 17500000);
    CHECK(ns_from_ms(0.1) == 100000);
    CHECK(ns_from_ms(1e-6) == 1);
    CHECK(ns_from_ms(0.4e-6) == 0);
    CHECK(ns_from_ms(0.6e-6) == 1);
    CHECK(ns_from_ms(3.6e6) == INT64_C(3600000000000));
    for (const double longer_ms : {1e13, 1e300, infinity}) {
        CHECK(ns_from_ms(longer_ms) == INT64_MAX);
    }
}
