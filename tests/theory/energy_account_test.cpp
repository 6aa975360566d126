/* The firmware's energy account against closed forms: what a dead time makes (Horiuchi 1999), what a damper takes,
 * what an integrator makes, and the work of forces and positions that arrive at different ages. */
#include <cmath>
#include <complex>
#include <doctest/doctest.h>

#include "../support/closed_loop.h"
#include "../support/key_value.h"

namespace berth
{

namespace
{

constexpr double swing_w = 2.0 * M_PI; /* 1 Hz, 400 ticks a cycle */
constexpr double amplitude_m = 0.05;
constexpr double hardware_N_per_m = 20000.0;

/* A manipulator so heavy that spring and damper of the hardware hardly matter to its swing of 1 Hz. */
std::vector<std::string> heavy_swing(double damping_N_s_per_m)
{
    constexpr double mass_kg = 1e7;
    return {set("manipulator.mass_kg", mass_kg),
            set("manipulator.stiffness_N_per_m", mass_kg * swing_w * swing_w - hardware_N_per_m),
            "manipulator.damping_N_s_per_m=0",
            set("manipulator.initial_position_m", amplitude_m),
            "object.mass_kg=0.001",
            set("object.stiffness_N_per_m", hardware_N_per_m),
            set("object.damping_N_s_per_m", damping_N_s_per_m),
            "sensor.stiffness_N_per_m=1e9",
            "limits.acceleration_m_per_s2=1e6",
            "run.duration_s=20"};
}

/* Sums over five cycles, once the robot follows. */
energy_sums over_cycles(closed_loop &loop)
{
    constexpr int settle = 1200;
    constexpr int cycles = 5;
    energy_sums at_first{};
    for (int running = 0; loop.tick();) {
        running += loop.is_running();
        if (running == settle) {
            at_first = loop.app().energy.sums;
        }
        if (running == settle + 400 * cycles) {
            const energy_sums &now = loop.app().energy.sums;
            const auto each = [&](double energy_sums::*sum) { return (now.*sum - at_first.*sum) / cycles; };
            return {now.stored_J,
                    each(&energy_sums::operator_J),
                    each(&energy_sums::dissipated_J),
                    each(&energy_sums::integrator_J),
                    each(&energy_sums::simulated_port_J),
                    each(&energy_sums::measured_port_J),
                    each(&energy_sums::dead_time_J),
                    each(&energy_sums::compensation_J)};
        }
    }
    FAIL("the run ended too early");
    return {};
}

/* Spring and damper behind the loop's delay and the sensor's low-pass, and the force held for a tick. */
std::complex<double> felt_stiffness(double damping_N_s_per_m, double delay_s)
{
    const std::complex<double> s(0.0, swing_w / (2.0 * M_PI * 20.0));
    return std::complex<double>(hardware_N_per_m, swing_w * damping_N_s_per_m) *
           std::polar(1.0, -swing_w * delay_s) / (s * s + 1.4 * s + 1.0);
}

void book_and_announce(energy_account *account, const operator_command *command, double force_N, double position_m,
                       int is_running)
{
    energy_account_book(account, command, force_N, position_m, 0.0, is_running);
    energy_account_announce(account, command, force_N, force_N, is_running);
}

double balance_J(const energy_sums &sums, double stored_at_start_J)
{
    return stored_at_start_J + sums.operator_J + sums.integrator_J - sums.dissipated_J - sums.simulated_port_J -
           sums.stored_J;
}

} // namespace

TEST_CASE("energy account: the dead time makes pi k tau w A^2 a cycle, the hardware takes pi d w A^2")
{
    const double unit_J = M_PI * amplitude_m * amplitude_m;
    for (const double damping_N_s_per_m : {0.0, 300.0}) {
        for (const double dead_time_ms : {7.5, 11.3, 17.5}) {
            CAPTURE(damping_N_s_per_m);
            CAPTURE(dead_time_ms);
            std::vector<std::string> overrides = heavy_swing(damping_N_s_per_m);
            overrides.push_back(set("robot.dead_time_ms", dead_time_ms));
            closed_loop loop("ess", overrides);
            const energy_sums sums = over_cycles(loop);
            const double delay_s = 1e-3 * (dead_time_ms + 2.5 + 1.25);
            const double given_J = unit_J * felt_stiffness(damping_N_s_per_m, delay_s).imag();
            const double taken_J = unit_J * swing_w * damping_N_s_per_m;
            const double allowance_J = 2e-3 * unit_J * hardware_N_per_m * swing_w * delay_s;
            CHECK(sums.simulated_port_J == doctest::Approx(given_J).epsilon(allowance_J / std::abs(given_J)));
            CHECK(std::abs(sums.measured_port_J - taken_J) < allowance_J);
            CHECK(std::abs(sums.dead_time_J - (taken_J - given_J)) < allowance_J);
            CHECK(sums.dead_time_J > 0.0);
            CHECK(sums.dissipated_J == 0.0);
            CHECK(sums.integrator_J == 0.0);
        }
    }
}

TEST_CASE("energy account: what comes in, what goes out and what is stored balance in every tick")
{
    for (const char *integrator : {"exact", "semi_implicit_euler", "rk4"}) {
        CAPTURE(integrator);
        closed_loop loop("ess", {std::string("manipulator.integrator=") + integrator, "sensor.noise_N=2",
                                 "profile.kind=minimum_jerk", "profile.amplitude_m=0.1", "profile.duration_s=3",
                                 "run.duration_s=8"});
        double stored_at_start_J = 0.0;
        double largest_J = 0.0;
        bool was_running = false;
        while (loop.tick()) {
            const energy_sums &sums = loop.app().energy.sums;
            if (!loop.is_running()) {
                continue;
            }
            stored_at_start_J = was_running ? stored_at_start_J : sums.stored_J;
            was_running = true;
            largest_J = std::max({largest_J, sums.stored_J, sums.dissipated_J});
            REQUIRE(std::abs(balance_J(sums, stored_at_start_J)) < 1e-11 * largest_J);
            REQUIRE(sums.measured_port_J == doctest::Approx(sums.simulated_port_J + sums.dead_time_J));
            const bool is_exact = std::string(integrator) == "exact";
            REQUIRE((sums.integrator_J == 0.0) == (is_exact || sums.simulated_port_J == 0.0));
        }
        CHECK(largest_J > 1.0);
    }
}

TEST_CASE("energy account: a free decay is all dissipated, a force that the operator holds gives F times the way")
{
    const std::vector<std::string> light = {"object.mass_kg=1e-6", "object.stiffness_N_per_m=0",
                                            "object.damping_N_s_per_m=0", "run.duration_s=10"};
    closed_loop decay("ess", light);
    double stored_at_start_J = 0.0;
    while (decay.tick()) {
        const energy_sums &sums = decay.app().energy.sums;
        stored_at_start_J = stored_at_start_J == 0.0 && decay.is_running() ? sums.stored_J : stored_at_start_J;
    }
    const energy_sums &left = decay.app().energy.sums;
    CHECK(left.stored_J < 0.01 * stored_at_start_J);
    CHECK(left.dissipated_J == doctest::Approx(stored_at_start_J - left.stored_J).epsilon(1e-6));
    CHECK(std::abs(left.operator_J) < 1e-9 * stored_at_start_J);

    std::vector<std::string> pushed = light;
    pushed.insert(pushed.end(), {"operator.interface=force", "profile.kind=step", "profile.amplitude_N=50",
                                 "manipulator.initial_position_m=0"});
    closed_loop push("ess", pushed);
    double way_m = 0.0;
    double before_m = 0.0;
    double force_N = 0.0;
    while (push.tick()) {
        const tick_record &record = push.app().recorder.tick;
        way_m += force_N != 0.0 ? record.manipulator_position_m - before_m : 0.0;
        before_m = record.manipulator_position_m;
        force_N = record.operator_force_N;
    }
    REQUIRE(force_N == doctest::Approx(50.0));
    CHECK(push.app().energy.sums.operator_J == doctest::Approx(force_N * way_m).epsilon(1e-9));
}

TEST_CASE("energy account: damping takes what it takes of the motion against the operator's, not of the motion")
{
    closed_loop loop("ess",
                     {"object.mass_kg=1e-6", "object.stiffness_N_per_m=0", "object.damping_N_s_per_m=0",
                      "manipulator.initial_position_m=0", "manipulator.damping_N_s_per_m=2000", "profile.kind=ramp",
                      "profile.amplitude_m=0.5", "profile.start_s=0", "profile.duration_s=10", "run.duration_s=10"});
    double at_half_J = 0.0;
    while (loop.tick()) {
        at_half_J = loop.app().recorder.tick.index == 2000 ? loop.app().energy.sums.dissipated_J : at_half_J;
    }
    REQUIRE(loop.app().recorder.tick.manipulator_velocity_m_per_s == doctest::Approx(0.05).epsilon(1e-3));
    CHECK(at_half_J > 0.01);
    CHECK(loop.app().energy.sums.dissipated_J - at_half_J < 1e-3 * at_half_J);
}

TEST_CASE("energy account: semi-implicit Euler takes T^2 F^2 / 2m a step, the exact step nothing")
{
    for (const int integrator : {INTEGRATOR_EXACT, INTEGRATOR_SEMI_IMPLICIT_EULER}) {
        CAPTURE(integrator);
        app_config config = config_default();
        config.manipulator = {150.0, 0.0, 0.0, 0.0, 0.3, integrator, 1, 1.0, 0.0, 0.0};
        manipulator free_mass;
        manipulator_start(&free_mass, &config);
        energy_account account;
        energy_account_start(&account, &config, &free_mass);
        constexpr int steps = 1000;
        constexpr double force_N = 40.0;
        const operator_command command{};
        for (int n = 0; n < steps; n++) {
            book_and_announce(&account, &command, force_N, 0.0, 1);
            manipulator_step(&free_mass, &command, force_N);
        }
        book_and_announce(&account, &command, force_N, 0.0, 1);
        const double period_s = config_period_s(&config);
        const double taken_J = integrator == INTEGRATOR_EXACT ? 0.0
                                                              : steps * period_s * period_s * force_N * force_N /
                                                                    (2.0 * config.manipulator.mass_kg);
        CHECK(account.sums.integrator_J == doctest::Approx(-taken_J).epsilon(1e-9));
    }
}

TEST_CASE("energy account: force and position of different ages are paired")
{
    constexpr double force_amplitude_N = 7.0;
    constexpr double swing_m = 0.02;
    constexpr double seconds = 5.0;
    for (const double force_age_ms : {0.0, 2.5, 13.6, 300.0}) {
        for (const double position_age_ms : {1.0, 2.5, 40.3}) {
            CAPTURE(force_age_ms);
            CAPTURE(position_age_ms);
            app_config config = config_default();
            config.energy = {force_age_ms, position_age_ms};
            manipulator resting;
            manipulator_start(&resting, &config);
            energy_account account;
            energy_account_start(&account, &config, &resting);
            REQUIRE(account.is_measuring);
            const operator_command command{};
            double before_J = 0.0;
            for (int n = 0; n <= 800; n++) {
                const double time_s = n * config_period_s(&config);
                const double force_N = force_amplitude_N * std::cos(swing_w * (time_s - 1e-3 * force_age_ms));
                const double position_m = swing_m * std::sin(swing_w * (time_s - 1e-3 * position_age_ms));
                book_and_announce(&account, &command, force_N, position_m, 1);
                before_J = n == 400 ? account.sums.measured_port_J : before_J;
            }
            /* F v = F A w cos^2: F A w / 2 in the mean of a cycle. */
            const double expected_J = 0.5 * force_amplitude_N * swing_m * swing_w;
            CHECK(account.sums.measured_port_J - before_J == doctest::Approx(expected_J).epsilon(1e-3));
        }
    }
    app_config config = config_default();
    config.energy.force_age_ms = 1e3 * seconds; /* older than what is kept */
    manipulator resting;
    manipulator_start(&resting, &config);
    energy_account account;
    energy_account_start(&account, &config, &resting);
    CHECK(!account.is_measuring);
}

TEST_CASE("energy account: begins anew when the loop begins to run, and stands while it does not")
{
    closed_loop loop("ess", {"run.emergency_stop_s=4", "run.duration_s=6"});
    energy_sums at_stop{};
    while (loop.tick()) {
        const energy_sums &sums = loop.app().energy.sums;
        if (loop.is_running()) {
            at_stop = sums;
        } else if (at_stop.stored_J > 0.0) {
            REQUIRE(sums.dissipated_J == at_stop.dissipated_J);
            REQUIRE(sums.dead_time_J == at_stop.dead_time_J);
        } else {
            REQUIRE(sums.stored_J == 0.0);
        }
    }
    CHECK(at_stop.dissipated_J > 0.0);

    app_config config = config_default();
    manipulator moving;
    manipulator_start(&moving, &config);
    moving.velocity_m_per_s = 1.0;
    energy_account account;
    energy_account_start(&account, &config, &moving);
    const operator_command command{};
    for (const int is_running : {1, 1, 1, 0, 1}) {
        book_and_announce(&account, &command, 10.0, 0.0, is_running);
        manipulator_step(&moving, &command, 10.0);
    }
    CHECK(account.sums.simulated_port_J == 0.0);
    CHECK(account.sums.stored_J > 0.0);
}

} // namespace berth
