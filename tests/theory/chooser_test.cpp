/* What fidelity is measured against, and which compensation is recommended. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/compensation/chooser.h"
#include "../../sim_hal/compensation/coupled_truth.h"
#include "../../sim_hal/stability/first_order_limit.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/stiff_object.h"

namespace berth
{

namespace
{

const std::vector<std::string> softer_object{"object.stiffness_N_per_m=15000"};

/* The copper sheet, with all of it elsewhere. */
std::vector<std::string> copper_at(double place_m)
{
    const auto at = [](const char *key, double value) { return std::string(key) + "=" + std::to_string(value); };
    return {at("object.surface_position_m", place_m), at("profile.offset_m", place_m - 0.02),
            at("manipulator.initial_position_m", place_m - 0.02), "profile.duration_s=1"};
}

} // namespace

TEST_CASE("coupled truth: swings with the frequency and damping of the coupled system")
{
    for (const auto &own : {std::vector<std::string>{}, stiff_object}) {
        const rig rig = load_rig("ess", own);
        const mode coupled = coupled_spectrum(rig).modes.front();
        const double w = 2.0 * M_PI * coupled.frequency_Hz;
        coupled_truth truth(rig);
        truth.start(0.01, 0.0);
        double off_m = 0.0;
        for (int n = 1; n <= 2000; n++) {
            truth.advance({});
            const double t = n * config_period_s(&rig.firmware);
            const double expected_m = 0.01 * std::exp(coupled.growth_per_s * t) *
                                      (std::cos(w * t) - coupled.growth_per_s / w * std::sin(w * t));
            off_m = std::max(off_m, std::abs(truth.position_m() - expected_m));
        }
        /* The sensor spring gives way by (k + m w^2)/k_S, and the frequency with it: over 5 s as many radians. */
        const double gives = std::abs(rig.object.stiffness_N_per_m - rig.object.mass_kg * w * w) / 2e7;
        CHECK(off_m < 0.01 * (1e-4 + 2.0 * w * 5.0 * gives));
    }
}

TEST_CASE("coupled truth: a free mass comes back from a damped wall as the closed form says")
{
    constexpr double mass_kg = 300.0;
    constexpr double w0 = 2.0 * M_PI * 3.0;
    for (const double ratio : {0.0, 0.05, 0.2}) {
        CAPTURE(ratio);
        rig rig = load_rig("ess", {"object.kind=contact", "object.mass_kg=0.001", "manipulator.mass_kg=300",
                                   "manipulator.stiffness_N_per_m=0", "manipulator.damping_N_s_per_m=0",
                                   "manipulator.initial_position_m=-0.001", "sensor.stiffness_N_per_m=1e9"});
        rig.object.stiffness_N_per_m = mass_kg * w0 * w0;
        rig.object.damping_N_s_per_m = 2.0 * ratio * mass_kg * w0;
        rig.sensor.damping_ratio = 1.0;
        REQUIRE(!complete_and_check(rig));
        coupled_truth truth(rig);
        truth.start(-0.001, 0.1);
        while (truth.position_m() > -0.0011) {
            truth.advance({});
        }
        /* The wall never pulls: it lets go where k x + d v = 0, later than at the end of the half swing. */
        const double z = std::sqrt(1.0 - ratio * ratio);
        const double angle = std::atan2(2.0 * ratio * z, 2.0 * ratio * ratio - 1.0);
        const double expected = ratio > 0.0 ? std::exp(-ratio / z * angle) : 1.0;
        CHECK(-truth.velocity_m_per_s() / 0.1 == doctest::Approx(expected).epsilon(2e-3));
    }
}

TEST_CASE("trial: without dead time to speak of there is no error, and noise shows as much as it moves")
{
    const rig near =
        load_rig("ess", {"loop.rate_Hz=4000", "bus.ideal=true", "robot.dead_time_ms=0.25", "sensor.delay_ms=0",
                         "sensor.damping_ratio=0.7", "sensor.low_pass_order=1", "sensor.low_pass_frequency_Hz=300",
                         "object.mass_kg=10", "limits.acceleration_m_per_s2=1e6"});
    const trial_result fine = run_trial(near, 3.0);
    CHECK(fine.ran);
    CHECK(fine.is_bounded);
    CHECK(fine.error < 0.02);
    const trial_result late = run_trial(load_rig("ess"), 3.0);
    CHECK(late.error > 2.0 * fine.error);
    const trial_result unstable = run_trial(load_rig("ess", stiff_object), 5.0);
    CHECK(!(unstable.ran && unstable.is_bounded));
}

TEST_CASE("trial: the robot is behind the manipulator by its dead time, and where it is with the adaptive inverse")
{
    const rig bare = load_rig("ess");
    const trial_result late = run_trial(bare, 10.0);
    /* Of two decaying swings, the loop's over the dead time and the truth's, squares over all of time. */
    const mode slow = loop_spectrum(bare).modes.front();
    const mode truth = coupled_spectrum(bare).modes.front();
    const double turn = 2.0 * M_PI * slow.frequency_Hz * 1e-3 * bare.robot.dead_time_ms;
    const double expected = 2.0 * std::sin(0.5 * turn) * std::sqrt(truth.growth_per_s / slow.growth_per_s);
    CHECK(late.robot_error / expected == doctest::Approx(1.0).epsilon(0.01));
    const trial_result met =
        run_trial(load_rig("ess", {"prediction.enabled=true", "adaptive_inverse.enabled=true"}), 10.0);
    MESSAGE("robot to manipulator: ", late.robot_error, ", with prediction and adaptive inverse ", met.robot_error);
    CHECK(met.robot_error < 0.1 * late.robot_error);
    CHECK(met.error < 0.02);
    const trial_result too_far = run_trial(
        load_rig("ess", {"prediction.enabled=true", "adaptive_inverse.enabled=true", "robot.gain_error=0.1"}), 10.0);
    CHECK(too_far.robot_error < 0.1 * late.robot_error);
}

TEST_CASE("trial: where zero lies changes nothing")
{
    for (const auto &unit : std::vector<std::vector<std::string>>{
             {}, {"prediction.enabled=true"}, {"adaptive_inverse.enabled=true", "force_lead.enabled=true"}}) {
        CAPTURE(unit.size());
        const auto trial_at = [&](double place_m) {
            auto settings = copper_at(place_m);
            settings.insert(settings.end(), unit.begin(), unit.end());
            return run_trial(load_rig("concept-copper", settings), 3.0);
        };
        const trial_result here = trial_at(0.0);
        const trial_result there = trial_at(0.5);
        CHECK(here.is_bounded == !unit.empty());
        CHECK(there.is_bounded == here.is_bounded);
        CHECK(there.error == doctest::Approx(here.error).epsilon(1e-3));
        CHECK(there.robot_error == doctest::Approx(here.robot_error).epsilon(1e-3));
    }
}

TEST_CASE("chooser: where zero lies changes nothing")
{
    choice_request request;
    request.duration_s = 2.0;
    request.rig = load_rig("concept-copper", copper_at(0.0));
    const choice here = choose_compensation(request);
    request.rig = load_rig("concept-copper", copper_at(0.5));
    const choice there = choose_compensation(request);
    const auto by_name = [&](const std::string &name) {
        return *std::find_if(there.methods.begin(), there.methods.end(),
                             [&](const method_verdict &other) { return other.method.name == name; });
    };
    for (const method_verdict &one : here.methods) {
        CAPTURE(one.method.name);
        const method_verdict other = by_name(one.method.name);
        CHECK(other.method.settings == one.method.settings);
        CHECK(other.is_robust == one.is_robust);
    }
    CHECK(there.methods.front().method.name == here.methods.front().method.name);
}

TEST_CASE("chooser: tries ten times the rig's noise, and refuses a rig on which nothing moves")
{
    choice_request request;
    request.duration_s = 0.5;
    const auto noise_of = [&](const std::vector<std::string> &settings) {
        request.rig = load_rig("ess", settings);
        const choice made = choose_compensation(request);
        const auto noisy = std::find_if(made.differences.begin(), made.differences.end(), [](const difference &one) {
            return one.name.find("noise") != std::string::npos;
        });
        REQUIRE(noisy != made.differences.end());
        return noisy->settings.front();
    };
    CHECK(noise_of({}) == "sensor.noise_N=2");
    CHECK(noise_of({"sensor.noise_N=1.5"}) == "sensor.noise_N=15");
    request.noise_N = 0.5;
    CHECK(noise_of({"sensor.noise_N=1.5"}) == "sensor.noise_N=0.5");
    request.rig = load_rig("ess", {"manipulator.initial_position_m=0"});
    CHECK_THROWS_WITH_AS(choose_compensation(request), doctest::Contains("nothing moves"), input_error);
}

TEST_CASE("coupled truth: once the object is let go the manipulator swings alone")
{
    const rig rig = load_rig("ess", {"run.grip_release_s=1"});
    const double period_s = config_period_s(&rig.firmware);
    const mode alone = manipulator_spectrum(rig).modes.front();
    const double w = 2.0 * M_PI * alone.frequency_Hz;
    const double decay = alone.growth_per_s;
    coupled_truth truth(rig);
    truth.start(0.01, 0.0, 0.5);
    for (int n = 0; n < 200; n++) {
        truth.advance({});
    }
    const double x = truth.position_m();
    const double v = truth.velocity_m_per_s();
    for (int n = 1; n <= 1000; n++) {
        truth.advance({});
        const double t = n * period_s;
        const double expected_m =
            std::exp(decay * t) * (x * std::cos(w * t) + (v - decay * x) / w * std::sin(w * t));
        REQUIRE(truth.position_m() == doctest::Approx(expected_m).epsilon(1e-6));
    }
}

TEST_CASE("trial: the growth of a swing is that of the eigenvalues, and says what becomes of it")
{
    for (const char *stiffness : {"2368.7", "6000", "15000"}) {
        const rig rig = load_rig("ess", {std::string("object.stiffness_N_per_m=") + stiffness});
        const double expected_per_s = loop_spectrum(rig).growth_per_s;
        const trial_result trial = run_trial(rig, 20.0);
        CAPTURE(stiffness);
        CHECK(trial.growth_per_s == doctest::Approx(expected_per_s).epsilon(0.05));
        CHECK(trial.fate == (expected_per_s < 0.0 ? fate::decays : fate::diverges));
    }
    const rig fast = load_rig("ess", {"object.damping_N_s_per_m=1500", "robot.dead_time_ms=2.5"});
    CHECK(run_trial(fast, 20.0).fate == fate::decays);
    const rig at_the_limit = load_rig("ess", {"object.stiffness_N_per_m=10660"});
    REQUIRE(std::abs(loop_spectrum(at_the_limit).growth_per_s) < 0.003);
    CHECK(run_trial(at_the_limit, 20.0).fate == fate::lasts);
}

TEST_CASE("chooser: the stiff object is compensated by prediction, and what is recommended holds on every rig tried")
{
    choice_request request;
    request.rig = load_rig("ess", stiff_object);
    request.duration_s = 5.0;
    const choice made = choose_compensation(request);
    REQUIRE(made.recommended() != nullptr);
    CHECK(made.recommended()->error < 0.05);
    CHECK(made.recommended()->method.name.rfind("identification", 0) == 0);
    for (std::size_t i = 0; i < made.differences.size(); i++) {
        const trial_result &trial = made.recommended()->trials[i];
        CAPTURE(made.differences[i].name);
        CHECK(trial.ran);
        CHECK(trial.is_bounded);
        /* That the object is gone takes a while to notice, whatever the method. */
        CHECK(trial.error < (made.differences[i].name == "object let go on the way" ? 0.5 : 0.15));
    }
    for (const method_verdict &verdict : made.methods) {
        if (verdict.method.name == "none") {
            CHECK(!verdict.is_robust);
        }
    }
}

TEST_CASE("dissipator: with the least damping the loop is at its limit where the margin is used up")
{
    for (const loop_margin &margin : {loop_margin{0.0, 0.0}, loop_margin{4.0, 0.0}, loop_margin{0.0, 2.0}}) {
        CAPTURE(margin.dead_time_ms);
        CAPTURE(margin.gain_dB);
        const auto damping = least_damping(load_rig("ess", softer_object), margin);
        REQUIRE(damping);
        REQUIRE(*damping > 0.0);
        const auto radius = [&](double factor) {
            rig at = load_rig("ess", softer_object);
            at.robot.dead_time_ms += margin.dead_time_ms;
            at.firmware.dissipation.damping_N_s_per_m = factor * *damping;
            REQUIRE(
                !set_value(at, "sensor.gain_error", std::to_string(std::pow(10.0, margin.gain_dB / 20.0) - 1.0)));
            REQUIRE(!complete_and_check(at));
            return spectral_radius_of(at);
        };
        CHECK(radius(1.01) < 1.0);
        CHECK(radius(0.98) > 1.0);
    }
    CHECK(least_damping(load_rig("ess"), {1.0, 0.0}) == 0.0);
    /* To first order in the delay a spring's negative damping is k tau, the mass's m tau w^2 the other way. */
    const rig soft = load_rig("ess", softer_object);
    const double first_order =
        2.0 * -first_order_damping_margin(soft) *
        std::sqrt((soft.firmware.manipulator.stiffness_N_per_m + soft.object.stiffness_N_per_m) *
                  (soft.firmware.manipulator.mass_kg + soft.object.mass_kg));
    CHECK(*least_damping(soft, {}) == doctest::Approx(first_order).epsilon(0.1));
}

} // namespace berth
