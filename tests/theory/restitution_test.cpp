/* A free mass hits an elastic wall that is displayed through dead time: coefficient of restitution against the table
 * of Li et al. (J. Aerosp. Eng. 2026), exp(-pi z / sqrt(1 - z^2)) with z = zeta - w0 tau / 2, at 3 Hz.
 *
 * tau is T_R + T_S + T/2: the straight lines pass through the setpoints T_R after they were sent, the force comes
 * T_S later and is then held for T, T/2 in the mean. At 10 kHz what is left of sampling is (w0 T)^2, 4e-6. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "../../sim_hal/bounce.h"
#include "../support/closed_loop.h"

namespace berth
{

namespace
{

constexpr double moving_kg = 100.0;
constexpr double w0 = 2.0 * M_PI * 3.0; /* rad/s */
constexpr double surface_N_per_m = moving_kg * w0 * w0;
constexpr double speed_m_per_s = 0.1;
constexpr double allowance = 0.002;

double damping_N_s_per_m(double damping_ratio)
{
    return 2.0 * damping_ratio * moving_kg * w0;
}

double published_formula(double damping_ratio, double delay_s)
{
    const double z = damping_ratio - 0.5 * w0 * delay_s;
    return std::exp(-M_PI * z / std::sqrt(1.0 - z * z));
}

struct row {
    double damping_ratio;
    double delay_ms;
    double restitution;
};

constexpr row table[] = {
    {0.0, 3.0, 1.0928}, {0.0, 3.5, 1.1090}, {0.0, 4.0, 1.1255},
    {0.1, 3.0, 0.7973}, {0.1, 3.5, 0.8093}, {0.1, 4.0, 0.8216},
};

/* 10 kHz, a gram of tool on a sensor 3000 times stiffer than the wall, no low-pass, and limits out of the way:
 * the velocity is there from one tick to the next. */
std::vector<std::string> impact(double damping_ratio, double delay_ms)
{
    const auto set = [](const char *key, double value) { return key + ("=" + std::to_string(value)); };
    return {"loop.rate_Hz=10000",
            "bus.ideal=true",
            "run.duration_s=0.6",
            "run.release_s=0.01",
            "manipulator.mass_kg=100",
            "manipulator.stiffness_N_per_m=0",
            "manipulator.damping_N_s_per_m=0",
            "limits.acceleration_m_per_s2=1e7",
            "limits.velocity_m_per_s=100",
            "robot.interpolation=linear",
            set("robot.dead_time_ms", delay_ms - 1.0 - 0.05),
            "sensor.delay_ms=1.0",
            "sensor.stiffness_N_per_m=1e8",
            "sensor.low_pass_order=0",
            "object.mass_kg=0.001",
            set("object.stiffness_N_per_m", surface_N_per_m),
            set("object.damping_N_s_per_m", damping_N_s_per_m(damping_ratio)),
            set("manipulator.initial_velocity_m_per_s", speed_m_per_s)};
}

double approach_and_rebound(double damping_ratio, double delay_ms, const std::string &solver)
{
    std::vector<std::string> overrides = impact(damping_ratio, delay_ms);
    overrides.insert(overrides.end(),
                     {"object.kind=contact", "manipulator.initial_position_m=-0.005", "solver.kind=" + solver});
    closed_loop loop("ess", overrides);
    double before_m_per_s = 0.0;
    double after_m_per_s = 0.0;
    double peak_force_N = 0.0;
    while (loop.tick() && loop.app().recorder.tick.manipulator_position_m > -0.006) {
        const tick_record &record = loop.app().recorder.tick;
        peak_force_N = std::max(peak_force_N, record.force_N);
        const bool is_approaching = record.manipulator_velocity_m_per_s > 0.0 && record.manipulator_position_m < 0.0;
        (is_approaching ? before_m_per_s : after_m_per_s) = record.manipulator_velocity_m_per_s;
    }
    REQUIRE(loop.app().limits.active_ticks[3] == 0);
    REQUIRE(peak_force_N > 0.5 * moving_kg * w0 * speed_m_per_s); /* without damping and delay: M w0 v */
    REQUIRE(before_m_per_s > 0.0);
    REQUIRE(after_m_per_s < 0.0);
    return -after_m_per_s / before_m_per_s;
}

/* The model of the table lets the damper pull until the wall is left: a gripped spring and damper, from the instant
 * at which it is felt first to that at which the position felt is 0 again. */
double half_cycle_on_gripped_object(double damping_ratio, double delay_ms, const std::string &solver)
{
    std::vector<std::string> overrides = impact(damping_ratio, delay_ms);
    overrides.insert(overrides.end(),
                     {"object.kind=gripped", "manipulator.initial_position_m=0", "solver.kind=" + solver});
    closed_loop loop("ess", overrides);
    std::vector<double> positions_m;
    std::vector<double> velocities_m_per_s;
    while (loop.tick() && loop.app().recorder.tick.manipulator_position_m > -0.01 * speed_m_per_s) {
        if (loop.is_running()) {
            positions_m.push_back(loop.app().recorder.tick.manipulator_position_m);
            velocities_m_per_s.push_back(loop.app().recorder.tick.manipulator_velocity_m_per_s);
        }
    }
    std::size_t back = 1;
    while (positions_m.at(back) > 0.0) {
        back++;
    }
    const double crossing =
        static_cast<double>(back) - positions_m[back] / (positions_m[back] - positions_m[back - 1]);
    const double felt = crossing + delay_ms / 0.1; /* in ticks */
    const auto i = static_cast<std::size_t>(felt);
    const double share = felt - static_cast<double>(i);
    return -((1.0 - share) * velocities_m_per_s.at(i) + share * velocities_m_per_s.at(i + 1)) / speed_m_per_s;
}

/* M x'' = -max(0, k x + d x') where x > 0, both tau ago: a second program, semi-implicit steps of 1 us. */
double delayed_wall_that_never_pulls(double damping_ratio, double delay_s)
{
    constexpr double step_s = 1e-6;
    const auto delay_steps = static_cast<std::size_t>(std::lround(delay_s / step_s));
    std::vector<double> x{0.0};
    std::vector<double> v{speed_m_per_s};
    for (std::size_t i = 0; i < delay_steps || x[i - delay_steps] > -1e-4; i++) {
        double force_N = 0.0;
        if (i >= delay_steps && x[i - delay_steps] > 0.0) {
            force_N = std::max(0.0, surface_N_per_m * x[i - delay_steps] +
                                        damping_N_s_per_m(damping_ratio) * v[i - delay_steps]);
        }
        v.push_back(v[i] - step_s * force_N / moving_kg);
        x.push_back(x[i] + step_s * v[i + 1]);
    }
    return -v.back() / speed_m_per_s;
}

} // namespace

/* It is first order in the delay: (w0 tau)^2 is 3e-3 to 6e-3. */
TEST_CASE("the formula gives the published restitution table")
{
    for (const row &r : table) {
        CHECK(std::abs(published_formula(r.damping_ratio, 1e-3 * r.delay_ms) - r.restitution) < 6e-4);
    }
}

TEST_CASE("restitution of a free mass against a one-sided elastic wall, table at zeta = 0")
{
    for (const row &r : table) {
        if (r.damping_ratio > 0.0) {
            continue; /* the table's damper pulls, a wall does not: see below */
        }
        for (const std::string solver : {"fast", "cvode"}) {
            CAPTURE(r.delay_ms);
            CAPTURE(solver);
            const double restitution = approach_and_rebound(r.damping_ratio, r.delay_ms, solver);
            CHECK(std::abs(restitution - r.restitution) < allowance);
        }
    }
}

TEST_CASE("restitution of a half cycle on a spring and damper, the whole table")
{
    for (const row &r : table) {
        for (const std::string solver : {"fast", "cvode"}) {
            if (solver == "cvode" && r.delay_ms != 3.5) {
                continue; /* a gram behind a damper is stiff, and Adams steps are slow in it: one row each will do */
            }
            CAPTURE(r.damping_ratio);
            CAPTURE(r.delay_ms);
            CAPTURE(solver);
            const double restitution = half_cycle_on_gripped_object(r.damping_ratio, r.delay_ms, solver);
            CHECK(std::abs(restitution - r.restitution) < allowance);
        }
    }
}

TEST_CASE("restitution against a damped wall that never pulls, another program")
{
    for (const row &r : table) {
        CAPTURE(r.damping_ratio);
        CAPTURE(r.delay_ms);
        const double expected = delayed_wall_that_never_pulls(r.damping_ratio, 1e-3 * r.delay_ms);
        const double restitution = approach_and_rebound(r.damping_ratio, r.delay_ms, "fast");
        CHECK(std::abs(restitution - expected) < 3e-4);
    }
}

rig rig_in_contact(double damping_ratio, double delay_ms)
{
    std::vector<std::string> overrides = impact(damping_ratio, delay_ms);
    overrides.insert(overrides.end(), {"object.kind=contact", "manipulator.initial_position_m=-0.005"});
    return load_rig("ess", overrides);
}

TEST_CASE("a played bounce has the published restitution")
{
    for (const row &r : table) {
        if (r.damping_ratio == 0.0) {
            CAPTURE(r.delay_ms);
            CHECK(std::abs(play_bounce(rig_in_contact(0.0, r.delay_ms))->restitution - r.restitution) < allowance);
        }
    }
}

/* w0 tau from 0.06 to 0.57, where the formula no longer holds. */
TEST_CASE("a played bounce against another program, far beyond small delays")
{
    for (const double damping_ratio : {0.0, 0.1, 0.3}) {
        for (const double delay_ms : {3.0, 10.0, 30.0}) {
            CAPTURE(damping_ratio);
            CAPTURE(delay_ms);
            const double expected = delayed_wall_that_never_pulls(damping_ratio, 1e-3 * delay_ms);
            CHECK(std::abs(play_bounce(rig_in_contact(damping_ratio, delay_ms))->restitution - expected) <
                  allowance);
        }
    }
}

/* By the formula a bounce gains energy where zeta < w0 tau / 2. */
TEST_CASE("the dead time at which a bounce gains energy, against another program")
{
    const auto found = find_bounce_limit(rig_in_contact(0.05, 3.0), "robot.dead_time_ms");
    REQUIRE(found);
    CHECK(found->gains_above);
    const double delay_ms = found->value + 1.0 + 0.05;
    CHECK(delayed_wall_that_never_pulls(0.05, 1e-3 * delay_ms) == doctest::Approx(1.0).epsilon(1e-3));
}

TEST_CASE("a bounce needs a tool in contact")
{
    CHECK_THROWS_WITH(play_bounce(load_rig("ess")), doctest::Contains("object.kind"));
}

TEST_CASE("with hardly any delay a wall gives back what it gets, and no more")
{
    CHECK(approach_and_rebound(0.0, 1.2, "fast") == doctest::Approx(published_formula(0.0, 1.2e-3)).epsilon(1e-3));
    CHECK(approach_and_rebound(0.1, 1.2, "fast") < 1.0);
}

} // namespace berth
