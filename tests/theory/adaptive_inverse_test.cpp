/* The adaptive inverse against robots whose inverse is known in closed form, and the force lead against forces that
 * are: motions are sums of sines, so every derivative is exact. */
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <memory>

#include "../../firmware/compensation/adaptive_inverse.h"
#include "../../firmware/compensation/force_lead.h"
#include "../../sim_hal/hil/random.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/closed_loop.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

using overrides = std::vector<std::string>;
using three = std::array<double, 3>;

constexpr double period_s = 0.0025;

/* 1.1, 1.9 and 3.1 Hz, some mm each, about a place that is not zero. */
double motion_m(double t_s, int derivative)
{
    static constexpr double sines[][2] = {{4e-3, 1.1}, {3e-3, 1.9}, {1e-3, 3.1}};
    double value = derivative == 0 ? 0.25 : 0.0;
    for (const auto &[amplitude_m, frequency_Hz] : sines) {
        const double w = 2.0 * M_PI * frequency_Hz;
        value += amplitude_m * std::pow(w, derivative) * std::sin(w * t_s + derivative * M_PI_2);
    }
    return value;
}

inverse_settings told(const three &coefficients)
{
    inverse_settings settings{};
    settings.period_s = period_s;
    settings.terms = 3;
    for (std::size_t i = 0; i < 3; i++) {
        settings.told[i] = coefficients[i];
        settings.tolerance[i] = (i == 0 ? 0.02 : 0.3) * coefficients[i];
    }
    settings.bandwidth_Hz = 5.0;
    settings.report_age_ticks = 1.4;
    settings.position_noise_m = 2e-5;
    settings.memory_s = 20.0;
    settings.correction_max_m = 0.05;
    return settings;
}

/* A robot that needs the setpoint true[0] x + true[1] x' + true[2] x'' to be at x, and reports it late. */
void show(adaptive_inverse &inverse, const three &truth, double duration_s, double noise_m, random_stream &random)
{
    const double age_s = period_s * inverse.settings.report_age_ticks;
    const auto ticks = static_cast<int>(duration_s / period_s);
    for (int n = 0; n < ticks; n++) {
        const double t_s = n * period_s;
        const double setpoint_m =
            truth[0] * (motion_m(t_s, 0) - 0.25) + 0.25 + truth[1] * motion_m(t_s, 1) + truth[2] * motion_m(t_s, 2);
        adaptive_inverse_learn(&inverse, setpoint_m, motion_m(t_s - age_s, 0) + noise_m * random.normal());
    }
}

constexpr three usual{1.0, 0.025, 5e-4};

} // namespace

TEST_CASE("adaptive inverse: follows a parabola exactly, and no further than its limit")
{
    const auto unit = std::make_unique<adaptive_inverse>();
    const inverse_settings settings = told(usual);
    adaptive_inverse_start(unit.get(), &settings, 0.0);
    const auto place = [](double t) { return 0.01 - 0.03 * t + 0.2 * t * t; };
    double setpoint_m = 0.0;
    for (int n = 0; n <= 10; n++) {
        setpoint_m = adaptive_inverse_follow(unit.get(), place(n * period_s));
    }
    const double t = 10 * period_s;
    CHECK(setpoint_m == doctest::Approx(place(t) + usual[1] * (-0.03 + 0.4 * t) + usual[2] * 0.4).epsilon(1e-10));
    const std::uint32_t at_first = unit->saturated; /* when the parabola began, all at once */
    CHECK(at_first == 2);
    CHECK(adaptive_inverse_follow(unit.get(), 1.0) == doctest::Approx(1.05));
    CHECK(adaptive_inverse_follow(unit.get(), 0.0) == doctest::Approx(-0.05));
    CHECK(unit->saturated == at_first + 2);
    CHECK(std::isnan(adaptive_inverse_follow(unit.get(), NAN))); /* the limits say what happens to it */
}

TEST_CASE("adaptive inverse: finds the inverse of a robot that is not the one that it was told")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 31);
    const auto unit = std::make_unique<adaptive_inverse>();
    const inverse_settings settings = told(usual);
    for (const three &truth : {three{1.01, 0.019, 3.5e-4}, three{0.99, 0.033, 7e-4}, usual}) {
        for (const double noise_m : {0.0, 2e-5}) {
            CAPTURE(truth[1]);
            CAPTURE(noise_m);
            adaptive_inverse_start(unit.get(), &settings, 0.25);
            show(*unit, truth, 20.0, noise_m, random);
            CHECK(unit->coefficient[0] == doctest::Approx(truth[0]).epsilon(2e-3));
            CHECK(unit->coefficient[1] == doctest::Approx(truth[1]).epsilon(5e-3));
            CHECK(unit->coefficient[2] == doctest::Approx(truth[2]).epsilon(0.05));
        }
    }
}

TEST_CASE("adaptive inverse: what is learnt of the gain moves no place, what is told does")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 34);
    const auto unit = std::make_unique<adaptive_inverse>();
    for (const double told_gain : {1.0, 1.02}) {
        const inverse_settings settings = told({told_gain, usual[1], usual[2]});
        adaptive_inverse_start(unit.get(), &settings, 0.25);
        show(*unit, {told_gain + 0.01, usual[1], usual[2]}, 20.0, 0.0, random);
        REQUIRE(unit->coefficient[0] == doctest::Approx(told_gain + 0.01).epsilon(2e-3));
        double setpoint_m = 0.0;
        for (int n = 0; n < 10; n++) {
            setpoint_m = adaptive_inverse_follow(unit.get(), 0.25);
        }
        CHECK(setpoint_m == doctest::Approx(told_gain * 0.25).epsilon(1e-12));
        const double step_m = 1e-3;
        for (int n = 0; n < 3; n++) {
            setpoint_m = adaptive_inverse_follow(unit.get(), 0.25 + step_m);
        }
        CHECK(setpoint_m - told_gain * 0.25 == doctest::Approx(unit->coefficient[0] * step_m).epsilon(1e-4));
    }
}

TEST_CASE("adaptive inverse: stays within three tolerances, whatever the robot does")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 32);
    const auto unit = std::make_unique<adaptive_inverse>();
    const inverse_settings settings = told(usual);
    for (const three &truth : {three{1.3, 0.1, 5e-3}, three{-1.0, -0.05, -1e-3}}) {
        adaptive_inverse_start(unit.get(), &settings, 0.25);
        show(*unit, truth, 20.0, 1e-3, random);
        for (std::size_t i = 0; i < 3; i++) {
            const double off = std::abs(unit->coefficient[i] - usual[i]) / settings.tolerance[i];
            CHECK(off <= 3.0 * (1.0 + 1e-12));
        }
        CHECK(std::abs(unit->coefficient[1] - usual[1]) > 2.9 * settings.tolerance[1]);
    }
}

TEST_CASE("adaptive inverse: at rest nothing is forgotten, and noise teaches nothing")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 33);
    const auto unit = std::make_unique<adaptive_inverse>();
    const inverse_settings settings = told(usual);
    const three truth{1.01, 0.019, 3.5e-4};
    adaptive_inverse_start(unit.get(), &settings, 0.25);
    show(*unit, truth, 20.0, 2e-5, random);
    const three learnt{unit->coefficient[0], unit->coefficient[1], unit->coefficient[2]};
    for (int n = 0; n < 40000; n++) { /* five times its memory */
        adaptive_inverse_learn(unit.get(), 0.25, 0.25 + 2e-5 * random.normal());
    }
    CHECK(unit->coefficient[1] == doctest::Approx(learnt[1]).epsilon(0.02));
    CHECK(unit->covariance[1][1] < 0.02); /* 1: nothing is known but what was told */
    adaptive_inverse_rest_at(unit.get(), 0.1);
    CHECK(unit->coefficient[1] == usual[1]);
    CHECK(adaptive_inverse_follow(unit.get(), 0.1) == doctest::Approx(0.1).epsilon(1e-12));
}

TEST_CASE(
    "adaptive inverse: told of a rig, its coefficients are the series of dead time, transfer behaviour and lag")
{
    const double w = 2.0 * M_PI * 12.0;
    /* A setpoint that is held comes half a tick later still. */
    for (const bool holds : {false, true}) {
        CAPTURE(holds);
        const double held_s = holds ? 0.5 * period_s : 0.0;
        const rig rig = load_rig("ess", {"robot.transfer_frequency_Hz=12", "robot.transfer_damping_ratio=0.6",
                                         "robot.lag_ms=4", "adaptive_inverse.enabled=true",
                                         holds ? "robot.interpolation=hold" : "robot.interpolation=linear"});
        const inverse_settings settings = inverse_settings_of(&rig.firmware);
        /* d/ds and d2/ds2 / 2 of exp(D s) (1 + 2 z/w s + s^2/w^2) (1 + T s) at 0, by differences. */
        const auto inverse = [&, dead_s = 0.0175 + held_s](double s) {
            return std::exp(dead_s * s) * (1.0 + 1.2 / w * s + s * s / (w * w)) * (1.0 + 0.004 * s);
        };
        constexpr double h = 0.02;
        CHECK(settings.told[0] == 1.0);
        CHECK(settings.told[1] == doctest::Approx((inverse(h) - inverse(-h)) / (2.0 * h)).epsilon(1e-6));
        CHECK(settings.told[2] == doctest::Approx((inverse(h) - 2.0 + inverse(-h)) / (2.0 * h * h)).epsilon(1e-6));
    }
}

TEST_CASE("adaptive inverse: in the loop the robot is where the manipulator is, though its delay was told wrong")
{
    const overrides slow{"robot.transfer_frequency_Hz=12",
                         "robot.transfer_damping_ratio=0.7",
                         "robot.lag_ms=3",
                         "profile.kind=multisine",
                         "profile.amplitude_m=0.01",
                         "profile.duration_s=20",
                         "profile.frequency_end_Hz=2",
                         "robot.feedback_noise_m=1e-5",
                         "run.duration_s=40",
                         "object.mass_kg=5"};
    const auto distance = [&](const overrides &more, double told_share) {
        overrides all = slow;
        all.insert(all.end(), more.begin(), more.end());
        rig rig = load_rig("ess", all);
        rig.firmware.hardware.setpoint_to_motion_ms *= told_share;
        closed_loop loop(rig);
        std::vector<double> past_m;
        double squares = 0.0;
        double swing = 0.0;
        while (loop.tick()) {
            const tick_record &record = loop.app().recorder.tick;
            if (!loop.is_running()) {
                continue;
            }
            past_m.push_back(record.manipulator_position_m);
            if (past_m.size() > 4000) { /* a report is a tick old */
                squares += std::pow(record.robot_position_m - past_m[past_m.size() - 2], 2);
                swing += std::pow(past_m.back(), 2);
            }
        }
        REQUIRE(past_m.size() > 14000);
        return std::sqrt(squares / swing);
    };
    const overrides adaptive{"adaptive_inverse.enabled=true"};
    const overrides fixed{"adaptive_inverse.enabled=true", "adaptive_inverse.tolerance=0",
                          "adaptive_inverse.gain_tolerance=0"};
    const double bare = distance({}, 1.0);
    MESSAGE("distance without: ", bare);
    for (const double share : {0.7, 1.0, 1.3}) {
        CAPTURE(share);
        const double with_adaptive = distance(adaptive, share);
        const double with_fixed = distance(fixed, share);
        MESSAGE("told ", share, " of the dead time: fixed ", with_fixed, ", adaptive ", with_adaptive);
        CHECK(with_adaptive < 0.1 * bare);
        if (share != 1.0) {
            CHECK(with_adaptive < 0.5 * with_fixed);
        }
    }
}

TEST_CASE("fixed inverse and force lead: growth in a run is that of the eigenvalues")
{
    const overrides fixed{"adaptive_inverse.enabled=true", "adaptive_inverse.tolerance=0",
                          "adaptive_inverse.gain_tolerance=0"};
    const overrides lead{"force_lead.enabled=true"};
    const overrides slow_lead{"force_lead.enabled=true", "force_lead.error_bandwidth_Hz=10"};
    overrides both = fixed;
    both.insert(both.end(), lead.begin(), lead.end());
    for (const overrides &method : {fixed, lead, slow_lead, both}) {
        CAPTURE(method.back());
        overrides own{"object.mass_kg=5",
                      "object.stiffness_N_per_m=20000",
                      "object.damping_N_s_per_m=20",
                      "manipulator.initial_position_m=1e-4",
                      "limits.acceleration_m_per_s2=1e6",
                      "run.duration_s=15"};
        own.insert(own.end(), method.begin(), method.end());
        const spectrum loop = loop_spectrum(load_rig("ess", own));
        closed_loop run("ess", own);
        const auto growth = fit_growth(free_motion_m(run), period_s, 1e-9);
        REQUIRE(growth);
        MESSAGE(method.back(), ": ", growth->growth_per_s, " 1/s, eigenvalues ", loop.growth_per_s);
        CHECK(growth->growth_per_s == doctest::Approx(loop.growth_per_s).epsilon(0.02));
    }
}

TEST_CASE("force lead: with the right model a late force comes as it is in the middle of the step")
{
    const auto unit = std::make_unique<force_lead>();
    force_lead_settings settings{};
    settings.period_s = period_s;
    settings.model.stiffness_N_per_m = 3e4;
    settings.model.damping_N_s_per_m = 50.0;
    settings.model.mass_kg = 7.0;
    settings.age_ticks = 5.0;
    settings.force_max_N = 1e4;
    const auto force_N = [&](double t_s) {
        return 3e4 * motion_m(t_s, 0) + 50.0 * motion_m(t_s, 1) + 7.0 * motion_m(t_s, 2);
    };
    for (const double bandwidth_Hz : {static_cast<double>(INFINITY), 5.0}) {
        for (const double bias_N : {0.0, 40.0}) {
            settings.bandwidth_Hz = bandwidth_Hz;
            force_lead_start(unit.get(), &settings);
            double worst_N = 0.0;
            for (int n = 0; n < 2000; n++) {
                const double t_s = n * period_s;
                const force_lead_motion motion{motion_m(t_s, 0), motion_m(t_s, 1), motion_m(t_s, 2),
                                               motion_m(t_s, 3)};
                const double led_N = force_lead_step(unit.get(), &motion, force_N(t_s - 5.0 * period_s) + bias_N);
                if (n > 1000) {
                    worst_N = std::max(worst_N, std::abs(led_N - bias_N - force_N(t_s + 0.5 * period_s)));
                }
            }
            /* Half a step on by the slope: what bends in it is left, k A (w T/2)^2 / 2 for each sine. */
            CHECK(worst_N < 0.05);
        }
    }
}

TEST_CASE("force lead: told of a rig, its age is the one at which the model says what is measured")
{
    const rig told = load_rig("ess", {"force_lead.enabled=true", "force_lead.error_bandwidth_Hz=7"});
    CHECK(force_lead_settings_of(&told.firmware).bandwidth_Hz == 7.0);
    /* What is measured beyond the model, as a share of it: least over ages about the right one. */
    const auto unexplained = [](const overrides &motion_side, double age_ms) {
        overrides own{"object.mass_kg=5",
                      "object.stiffness_N_per_m=2000",
                      "profile.kind=multisine",
                      "profile.amplitude_m=0.01",
                      "profile.duration_s=10",
                      "profile.frequency_end_Hz=2",
                      "run.duration_s=12",
                      "force_lead.enabled=true",
                      "force_lead.age_ms=" + std::to_string(age_ms)};
        own.insert(own.end(), motion_side.begin(), motion_side.end());
        closed_loop loop("ess", own);
        double squares = 0.0;
        double in_all = 0.0;
        while (loop.tick()) {
            if (loop.is_running()) {
                squares += std::pow(loop.app().recorder.tick.lead_error_N, 2);
                in_all += std::pow(loop.app().recorder.tick.force_N, 2);
            }
        }
        REQUIRE(in_all > 0.0);
        return std::sqrt(squares / in_all);
    };
    const overrides inverse{"adaptive_inverse.enabled=true", "adaptive_inverse.tolerance=0",
                            "adaptive_inverse.gain_tolerance=0"};
    for (const overrides &motion_side : {overrides{}, inverse}) {
        overrides own{"force_lead.enabled=true"};
        own.insert(own.end(), motion_side.begin(), motion_side.end());
        const rig leading = load_rig("ess", own);
        const double age_ms = 1e3 * period_s * force_lead_settings_of(&leading.firmware).age_ticks;
        const double here = unexplained(motion_side, age_ms);
        const double younger = unexplained(motion_side, age_ms - 1.0);
        const double older = unexplained(motion_side, age_ms + 1.0);
        MESSAGE(age_ms, " ms: ", here, "; 1 ms less ", younger, ", 1 ms more ", older);
        CHECK(here < std::min(younger, older));
    }
}

} // namespace berth
