#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "firmware/manipulator.h"
#include "seeded.h"

namespace
{

struct motion {
    double position_m, velocity_m_per_s;
};

/* M x'' + D x' + K x = f for constant f, by the textbook's cases; `at` is the time since (x0, v0). */
motion closed_form(double M, double D, double K, double f, motion start, double t)
{
    const double x0 = start.position_m, v0 = start.velocity_m_per_s;
    if (K == 0.0 && D == 0.0) {
        return {x0 + v0 * t + 0.5 * f / M * t * t, v0 + f / M * t};
    }
    if (K == 0.0) {
        const double v_end = f / D, rate = D / M;
        const double decayed = -std::expm1(-rate * t);
        return {x0 + v_end * t + (v0 - v_end) / rate * decayed, v0 + (v_end - v0) * decayed};
    }
    const double rest = f / K, y0 = x0 - rest;
    const double s = 0.5 * D / M, w2 = K / M, discriminant = s * s - w2;
    if (discriminant < 0.0) {
        const double wd = std::sqrt(-discriminant), b = (v0 + s * y0) / wd;
        const double c = std::cos(wd * t), n = std::sin(wd * t), decay = std::exp(-s * t);
        return {rest + decay * (y0 * c + b * n), decay * (v0 * c - (s * b + wd * y0) * n)};
    }
    if (discriminant == 0.0) {
        const double b = v0 + s * y0, decay = std::exp(-s * t);
        return {rest + decay * (y0 + b * t), decay * (v0 - s * b * t)};
    }
    const double root = std::sqrt(discriminant), fast = -s - root, slow = w2 / fast;
    const double a = (v0 - fast * y0) / (slow - fast), b = y0 - a;
    const double es = std::exp(slow * t), ef = std::exp(fast * t);
    return {rest + a * es + b * ef, a * slow * es + b * fast * ef};
}

app_config config_of(double mass_kg, double damping, double stiffness, std::int64_t rate_Hz)
{
    app_config config = config_default();
    config.loop.rate_Hz = rate_Hz;
    config.manipulator.mass_kg = mass_kg;
    config.manipulator.damping_N_s_per_m = damping;
    config.manipulator.stiffness_N_per_m = stiffness;
    config.manipulator.initial_position_m = 0.02;
    config.manipulator.initial_velocity_m_per_s = -0.3;
    return config;
}

constexpr operator_command command = {0.05, 0.1, 30.0, OPERATOR_RUN};
constexpr double force_N = 12.5;

/* The constant right-hand side that command and measured force make. */
double load_N(const app_config &config)
{
    const manipulator_config &m = config.manipulator;
    return m.stiffness_N_per_m * command.position_m + m.damping_N_s_per_m * command.velocity_m_per_s +
           command.force_N - force_N;
}

motion expected_at(const app_config &config, double time_s)
{
    const manipulator_config &m = config.manipulator;
    return closed_form(m.mass_kg, m.damping_N_s_per_m, m.stiffness_N_per_m, load_N(config),
                       {m.initial_position_m, m.initial_velocity_m_per_s}, time_s);
}

manipulator stepped(const app_config &config, int ticks)
{
    manipulator manipulator;
    manipulator_start(&manipulator, &config);
    for (int i = 0; i < ticks; i++) {
        manipulator_step(&manipulator, &command, force_N);
    }
    return manipulator;
}

struct system_case {
    const char *name;
    double mass_kg, damping, stiffness;
};

constexpr double reference_stiffness = 7895.6835208714865;
constexpr double reference_damping = 125.66370614359172;

const system_case systems[] = {
    {"reference, zeta 0.05", 200.0, reference_damping, reference_stiffness},
    {"undamped", 200.0, 0.0, reference_stiffness},
    {"free mass", 200.0, 0.0, 0.0},
    {"mass and damper", 200.0, 50.0, 0.0},
    {"overdamped, zeta 4", 200.0, 80.0 * reference_damping, reference_stiffness},
    {"critically damped", 200.0, 400.0, 200.0},
    {"stiff: 30 Hz at 50 Hz", 1.0, 10.0, 35530.0},
};

} // namespace

TEST_CASE("manipulator: the exact step is the closed form, whatever the damping and the rate")
{
    for (const system_case &system : systems) {
        for (const std::int64_t rate_Hz : {50, 400, 1000}) {
            CAPTURE(std::string(system.name));
            CAPTURE(rate_Hz);
            const app_config config = config_of(system.mass_kg, system.damping, system.stiffness, rate_Hz);
            for (const int ticks : {1, 10, 1000}) {
                CAPTURE(ticks);
                const manipulator reached = stepped(config, ticks);
                const motion expected = expected_at(config, ticks * config_period_s(&config));
                /* A rounding error a tick, and it may add up. */
                const double scale = 1.0 + std::fabs(expected.position_m) + std::fabs(expected.velocity_m_per_s);
                const double tolerance = scale * (1e-14 + 1e-15 * ticks);
                CHECK(std::fabs(reached.position_m - expected.position_m) <= tolerance);
                const double frequency_rad_per_s = std::sqrt(system.stiffness / system.mass_kg);
                CHECK(std::fabs(reached.velocity_m_per_s - expected.velocity_m_per_s) <=
                      tolerance * (1.0 + frequency_rad_per_s));
            }
        }
    }
}

TEST_CASE("manipulator: the exact step holds for any parameters")
{
    SEEDED(random, "manipulator:*");
    for (int run = 0; run < 500; run++) {
        CAPTURE(run);
        const double mass_kg = seeded::log_uniform(random, 1.0, 1e4);
        const double w = seeded::log_uniform(random, 0.1, 200.0), zeta = seeded::log_uniform(random, 1e-3, 5.0);
        const app_config config = config_of(mass_kg, 2.0 * zeta * w * mass_kg, w * w * mass_kg, 400);
        const manipulator reached = stepped(config, 20);
        const motion expected = expected_at(config, 20 * config_period_s(&config));
        const double scale = 1.0 + std::fabs(load_N(config)) / config.manipulator.stiffness_N_per_m;
        CHECK(std::fabs(reached.position_m - expected.position_m) <= 1e-12 * scale);
        CHECK(std::fabs(reached.velocity_m_per_s - expected.velocity_m_per_s) <= 1e-12 * scale * (1.0 + w));
    }
}

TEST_CASE("manipulator: the measured force brakes, the operator's force drives")
{
    const app_config config = config_of(10.0, 0.0, 0.0, 400);
    manipulator manipulator;
    manipulator_start(&manipulator, &config);
    manipulator_rest_at(&manipulator, 0.0);
    const operator_command push = {0.0, 0.0, 100.0, OPERATOR_RUN};
    manipulator_step(&manipulator, &push, 0.0);
    CHECK(manipulator.velocity_m_per_s == doctest::Approx(100.0 / 10.0 * 0.0025).epsilon(1e-13));
    manipulator_rest_at(&manipulator, 0.0);
    manipulator_step(&manipulator, &push, 150.0);
    CHECK(manipulator.velocity_m_per_s == doctest::Approx(-50.0 / 10.0 * 0.0025).epsilon(1e-13));
}

TEST_CASE("manipulator: starts where the configuration says and rests where it is put")
{
    const app_config config = config_of(10.0, 1.0, 100.0, 400);
    manipulator manipulator;
    manipulator_start(&manipulator, &config);
    CHECK(manipulator.position_m == 0.02);
    CHECK(manipulator.velocity_m_per_s == -0.3);
    manipulator_rest_at(&manipulator, 0.4);
    CHECK(manipulator.position_m == 0.4);
    CHECK(manipulator.velocity_m_per_s == 0.0);
    const operator_command stay = {0.4, 0.0, 0.0, OPERATOR_RUN};
    manipulator_step(&manipulator, &stay, 0.0);
    CHECK(manipulator.position_m == doctest::Approx(0.4).epsilon(1e-15));
    CHECK(std::fabs(manipulator.velocity_m_per_s) <= 1e-15);
}

TEST_CASE("manipulator: semi-implicit Euler converges with order 1, RK4 with order 4")
{
    const struct {
        integrator method;
        double order;
        std::vector<std::int64_t> substeps;
    } rows[] = {
        {INTEGRATOR_SEMI_IMPLICIT_EULER, 1.0, {125, 250, 500, 1000}},
        {INTEGRATOR_RK4, 4.0, {4, 8, 16, 32}},
    };
    for (const auto &row : rows) {
        CAPTURE(row.method);
        app_config config = config_of(200.0, reference_damping, reference_stiffness, 50);
        config.manipulator.integrator = row.method;
        const double w = std::sqrt(reference_stiffness / 200.0);
        const motion expected = expected_at(config, 0.7);
        double coarser = 0.0;
        for (const std::int64_t substeps : row.substeps) {
            config.manipulator.substeps = substeps;
            const manipulator reached = stepped(config, 35);
            const double error = std::hypot(reached.position_m - expected.position_m,
                                            (reached.velocity_m_per_s - expected.velocity_m_per_s) / w);
            if (coarser > 0.0) {
                const double order = std::log2(coarser / error);
                CAPTURE(substeps);
                CHECK(order == doctest::Approx(row.order).epsilon(0.02));
            }
            coarser = error;
        }
    }
}

TEST_CASE("manipulator: n substeps are n periods of an n times faster loop")
{
    for (const integrator method : {INTEGRATOR_SEMI_IMPLICIT_EULER, INTEGRATOR_RK4}) {
        CAPTURE(method);
        app_config slow = config_of(200.0, reference_damping, reference_stiffness, 50);
        slow.manipulator.integrator = method;
        app_config fast = slow;
        slow.manipulator.substeps = 8;
        fast.loop.rate_Hz = 400;
        const manipulator with_substeps = stepped(slow, 10);
        const manipulator with_rate = stepped(fast, 80);
        CHECK(with_substeps.position_m == with_rate.position_m);
        CHECK(with_substeps.velocity_m_per_s == with_rate.velocity_m_per_s);
    }
}

TEST_CASE("manipulator: the integrators differ from each other, and one step of each is its textbook formula")
{
    app_config config = config_of(2.0, 3.0, 50.0, 50);
    const double h = config_period_s(&config), x = 0.02, v = -0.3;
    const auto acceleration = [&](double at_m, double at_m_per_s) {
        return (load_N(config) - 50.0 * at_m - 3.0 * at_m_per_s) / 2.0;
    };
    config.manipulator.integrator = INTEGRATOR_SEMI_IMPLICIT_EULER;
    const manipulator euler = stepped(config, 1);
    const double v_euler = v + h * acceleration(x, v);
    CHECK(euler.velocity_m_per_s == doctest::Approx(v_euler).epsilon(1e-14));
    CHECK(euler.position_m == doctest::Approx(x + h * v_euler).epsilon(1e-14));

    config.manipulator.integrator = INTEGRATOR_RK4;
    const manipulator rk4 = stepped(config, 1);
    const double k1 = acceleration(x, v), v2 = v + 0.5 * h * k1;
    const double k2 = acceleration(x + 0.5 * h * v, v2), v3 = v + 0.5 * h * k2;
    const double k3 = acceleration(x + 0.5 * h * v2, v3), v4 = v + h * k3;
    const double k4 = acceleration(x + h * v3, v4);
    CHECK(rk4.velocity_m_per_s == doctest::Approx(v + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)).epsilon(1e-14));
    CHECK(rk4.position_m == doctest::Approx(x + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)).epsilon(1e-14));
    CHECK(euler.position_m != rk4.position_m);
}
