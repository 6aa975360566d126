/* The compensation units against closed forms, the exact solver, and the loop that they run in. */
#include <algorithm>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <Eigen/Core>
#include <memory>

#include "../../firmware/compensation/compensation.h"
#include "../../firmware/compensation/delay_shares.h"
#include "../../sim_hal/hil/random.h"
#include "../../sim_hal/solver/decompositions.h"
#include "../../sim_hal/stability/hardware_period.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/closed_loop.h"
#include "../support/key_value.h"
#include "../support/seed.h"
#include "../support/stiff_object.h"

namespace berth
{

namespace
{

using overrides = std::vector<std::string>;

overrides operator+(overrides a, const overrides &b)
{
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

const overrides with_prediction{"prediction.enabled=true"};

/* Of manipulator, sensor spring and object without dead time: the slowest, as d/dt. */
std::complex<double> coupled_mode_per_s(const rig &rig)
{
    const manipulator_config &arm = rig.firmware.manipulator;
    const object_rig &object = rig.object;
    const double k = rig.sensor.stiffness_N_per_m;
    const double d = 2.0 * rig.sensor.damping_ratio * std::sqrt(k * object.mass_kg);
    Eigen::Matrix4d a = Eigen::Matrix4d::Zero(); /* positions and velocities of both */
    a(0, 1) = a(2, 3) = 1.0;
    a.row(1) << -arm.stiffness_N_per_m - k, -arm.damping_N_s_per_m - d, k, d;
    a.row(1) /= arm.mass_kg;
    a.row(3) << k, d, -object.stiffness_N_per_m - k, -object.damping_N_s_per_m - d;
    a.row(3) /= object.mass_kg;
    const Eigen::Vector4cd all = berth::eigenvalues(a);
    return *std::min_element(all.begin(), all.end(), [](const auto &one, const auto &other) {
        return std::pair(std::abs(one), -one.imag()) < std::pair(std::abs(other), -other.imag());
    });
}

} // namespace

TEST_CASE("extrapolation: a polynomial of its order is met exactly, a sine as Horiuchi has it")
{
    for (const double delay_ms : {20.0, 33.7}) {
        for (int order = 1; order <= 3; order++) {
            CAPTURE(order);
            CAPTURE(delay_ms);
            const rig rig =
                load_rig("ess", {set("extrapolation.order", order), set("extrapolation.delay_ms", delay_ms)});
            const double period_s = config_period_s(&rig.firmware);
            const double delay_s = 1e-3 * delay_ms;
            const auto unit = std::make_unique<extrapolation>();
            const auto last = [&](const auto &signal) {
                extrapolation_start(unit.get(), &rig.firmware);
                double reached = 0.0;
                for (int n = 0; n <= 400; n++) {
                    reached = extrapolation_step(unit.get(), signal(n * period_s));
                }
                return reached;
            };
            const auto line = [](double t) { return 0.3 - 2.0 * t; };
            CHECK(last(line) == doctest::Approx(line(1.0 + delay_s)).epsilon(1e-12));
            const bool is_on_ticks = delay_ms == 20.0; /* between ticks the past is on straight lines */
            const auto power = [&](double t) { return std::pow(t, order); };
            CHECK(last(power) == doctest::Approx(power(1.0 + delay_s)).epsilon(is_on_ticks ? 1e-10 : 1e-4));
            const double w = 2.0 * M_PI * 3.0;
            const std::complex<double> late = std::polar(1.0, -w * delay_s);
            const std::complex<double> gain = (1.0 - std::pow(1.0 - late, order + 1)) / late;
            const auto cosine = [&](double t) { return std::cos(w * t); };
            CHECK(last(cosine) ==
                  doctest::Approx((gain * std::polar(1.0, w)).real()).epsilon(is_on_ticks ? 1e-9 : 2e-3));
        }
    }
}

TEST_CASE("extrapolation: its damping of a spring is positive up to w d = pi/3 (n = 2) and pi/2 (n = 3)")
{
    const struct {
        int order;
        double limit;
    } rows[] = {{2, M_PI / 3.0}, {3, M_PI / 2.0}};
    for (const auto &row : rows) {
        for (const double phase : {0.9 * row.limit, 1.1 * row.limit}) {
            const std::complex<double> felt =
                1.0 - std::pow(1.0 - std::polar(1.0, -phase), row.order + 1); /* of a spring, phase = w d */
            CHECK((felt.imag() > 0.0) == (phase < row.limit));
        }
    }
}

TEST_CASE("hardware twin: what it says is what the exact solver says, for setpoints of all kinds")
{
    REPRODUCIBLE();
    const overrides hold{"robot.interpolation=hold"};
    const overrides between{"robot.dead_time_ms=13.3", "sensor.delay_ms=4.1"};
    const overrides cases[] = {
        {},
        between,
        hold,
        hold + between,
        {"robot.transfer_frequency_Hz=12", "robot.dead_time_ms=6.1"},
        hold + overrides{"robot.transfer_frequency_Hz=12", "robot.lag_ms=5"},
        {"sensor.low_pass_order=1", "robot.dead_time_ms=8.8"},
        {"sensor.low_pass_order=1", "sensor.lag_ms=6", "robot.lag_ms=3"},
        {"sensor.low_pass_order=0", "robot.dead_time_ms=8.8"},
        {"sensor.low_pass_order=0"},
        hold + overrides{"sensor.low_pass_order=0"},
        hold + overrides{"sensor.low_pass_order=1"},
        hold + overrides{"sensor.low_pass_order=0", "sensor.lag_ms=2", "robot.dead_time_ms=8.8"},
        {"sensor.gain_error=-0.2", "robot.gain_error=0.1"},
        {"sensor.sample_phase_ms=1.2", "robot.dead_time_ms=8.8"},
        {"loop.rate_Hz=50", "robot.dead_time_ms=40", "sensor.delay_ms=20"},
    };
    random_stream random(test_seed(), 21);
    for (const overrides &own : cases) {
        CAPTURE(own.empty() ? std::string("ess") : own.back());
        const rig rig = load_rig("ess", own + overrides{"manipulator.initial_position_m=0"});
        const hardware_period hardware(rig);
        const auto twin = std::make_unique<hardware_twin>();
        hardware_twin_start(twin.get(), &rig.firmware.hardware, config_period_s(&rig.firmware), 0.0);
        beam_state state = beam_state::Zero();
        std::vector<double> setpoints(40, 0.0);
        std::vector<double> samples(40, 0.0);
        double largest_N = 0.0;
        double error_N = 0.0;
        const auto dead = static_cast<std::size_t>(hardware.whole_dead_periods());
        const auto age = static_cast<std::size_t>(hardware.sample_age_ticks());
        for (int n = 0; n < 300; n++) {
            setpoints.push_back(setpoints.back() + 1e-3 * (random.uniform() - 0.5));
            const auto before = [&](std::size_t ticks) { return setpoints[setpoints.size() - 1 - ticks]; };
            samples.push_back(
                hardware.advance(state, {dead > 0 ? before(dead - 1) : 0.0, before(dead), before(dead + 1)}));
            const double measured_N = samples[samples.size() - 1 - age];
            /* The solver counts the gains with the setpoints or with the samples: together they are the same. */
            hardware_twin_step(twin.get(), setpoints.back());
            error_N = std::max(error_N, std::abs(hardware_twin_sample(twin.get(), 0.0) - measured_N));
            largest_N = std::max(largest_N, std::abs(measured_N));
        }
        REQUIRE(largest_N > 1.0);
        CHECK(error_N < 1e-8 * largest_N);
    }
}

TEST_CASE("hardware twin: the robot's gain is that of its motion, not of its dead time")
{
    closed_loop loop("ess", with_prediction + overrides{"identification.enabled=true", "robot.gain_error=0.1",
                                                        "run.duration_s=10"});
    double off_ms = 0.0;
    double error_N = 0.0;
    double peak_N = 0.0;
    while (loop.tick()) {
        if (loop.is_running()) {
            off_ms = std::max(off_ms, std::abs(prediction_belief(&loop.app().compensation.prediction).dead_time_ms -
                                               loop.app().config.hardware.setpoint_to_motion_ms));
            error_N = std::max(error_N, std::abs(loop.app().recorder.tick.predicted_error_N));
            peak_N = std::max(peak_N, std::abs(loop.app().recorder.tick.force_N));
        }
    }
    REQUIRE(peak_N > 1.0);
    CHECK(off_ms < 0.01);
    CHECK(error_N < 1e-3 * peak_N);
}

TEST_CASE("compensation: no part of the dead time is made up for twice, however units are combined")
{
    const overrides inverse{"adaptive_inverse.enabled=true", "adaptive_inverse.tolerance=0",
                            "adaptive_inverse.gain_tolerance=0"};
    const overrides lead{"force_lead.enabled=true"};
    const overrides line{"extrapolation.order=1"};
    for (const overrides &robot :
         {overrides{}, overrides{"robot.transfer_frequency_Hz=20", "robot.lag_ms=2", "sensor.lag_ms=1"},
          overrides{"robot.transfer_frequency_Hz=20", "robot.interpolation=hold"}}) {
        for (const overrides &units : {line, lead, inverse + line, inverse + lead, line + lead,
                                       line + lead + overrides{"extrapolation.delay_ms=5"},
                                       line + lead + overrides{"force_lead.age_ms=5"}, inverse + line + lead}) {
            CAPTURE(units.back());
            CAPTURE(units.size());
            CAPTURE(robot.size());
            /* Hardly a mass, so that only the dead time makes the swing's growth differ. */
            const rig rig =
                load_rig("ess", robot + overrides{"object.mass_kg=1", "object.stiffness_N_per_m=3000"} + units);
            const app_config &c = rig.firmware;
            const double motion_ms = c.hardware.loop_delay_ms - c.energy.force_age_ms - c.hardware.sensor_lag_ms -
                                     0.5e3 * config_period_s(&c);
            double led_ms = c.adaptive_inverse.enabled ? motion_ms : 0.0;
            led_ms += c.extrapolation.order > 0 ? extrapolation_delay_ms(&c) : 0.0;
            led_ms += c.force_lead.enabled ? force_lead_age_ms(&c) + 0.5e3 * config_period_s(&c) : 0.0;
            CHECK(led_ms == doctest::Approx(c.hardware.loop_delay_ms).epsilon(1e-12));
            CHECK(loop_spectrum(rig).modes.front().growth_per_s ==
                  doctest::Approx(coupled_mode_per_s(rig).real()).epsilon(0.05));
        }
    }
}

TEST_CASE("compensation: the inverse filter makes the loop's delay shorter")
{
    const overrides slow{"robot.transfer_frequency_Hz=12", "object.mass_kg=1", "object.stiffness_N_per_m=3000"};
    const overrides filter{"inverse_filter.enabled=true"};
    for (const overrides &unit : {overrides{"extrapolation.order=1"}, overrides{"force_lead.enabled=true"}}) {
        const rig rig = load_rig("ess", slow + filter + unit);
        CHECK(rig.firmware.hardware.loop_delay_ms <
              load_rig("ess", slow + unit).firmware.hardware.loop_delay_ms - 10.0);
        CHECK(loop_spectrum(rig).modes.front().growth_per_s ==
              doctest::Approx(coupled_mode_per_s(rig).real()).epsilon(0.05));
    }
}

TEST_CASE("prediction: with the right model the loop swings as manipulator and object without dead time do")
{
    for (const overrides &own : {overrides{}, stiff_object, overrides{"robot.dead_time_ms=57.5"},
                                 overrides{"robot.interpolation=hold", "robot.dead_time_ms=13.3"},
                                 overrides{"robot.interpolation=hold", "sensor.low_pass_order=0"}}) {
        CAPTURE(own.empty() ? std::string("ess") : own.front());
        const rig rig = load_rig("ess", own + with_prediction);
        const spectrum loop = loop_spectrum(rig);
        CHECK(loop.is_stable);
        const std::complex<double> turn = coupled_mode_per_s(rig) * config_period_s(&rig.firmware);
        double nearest = 1.0;
        for (const mode &mode : loop.modes) {
            nearest = std::min(nearest, std::abs(mode.z - std::exp(turn)));
        }
        /* The force is held over a tick, so the way made in it is that of the trapezoidal rule: (w T)^2 / 12. */
        CHECK(nearest < std::pow(std::abs(turn), 3) / 12.0);
    }
    CHECK(!loop_spectrum(load_rig("ess", stiff_object)).is_stable);
}

TEST_CASE("prediction: feels the object through a sensor spring that gives way")
{
    for (const double sensor_N_per_m : {1e7, 5e6, 2e6}) {
        CAPTURE(sensor_N_per_m);
        const rig rig =
            load_rig("ess", overrides{set("sensor.stiffness_N_per_m", sensor_N_per_m),
                                      "object.stiffness_N_per_m=420000", "object.damping_N_s_per_m=400"} +
                                with_prediction);
        const double period_s = config_period_s(&rig.firmware);
        const std::complex<double> coupled_per_s = coupled_mode_per_s(rig);
        double off = 1.0; /* of the frequency */
        for (const mode &mode : loop_spectrum(rig).modes) {
            off = std::min(off, std::abs(std::log(mode.z) / period_s - coupled_per_s) / std::abs(coupled_per_s));
        }
        const double rigid_per_s = 2.0 * M_PI * coupled_spectrum(rig).modes.front().frequency_Hz;
        const double off_if_rigid = rigid_per_s / std::abs(coupled_per_s) - 1.0;
        /* What a force that is held makes of it, and what is of higher order in the softness. */
        const double held = std::pow(std::abs(coupled_per_s) * period_s, 2) / 12.0;
        MESSAGE("off by ", off, ", a rigid sensor ", off_if_rigid);
        CHECK(off_if_rigid > 0.005);
        CHECK(off < held + off_if_rigid * off_if_rigid);
    }
}

TEST_CASE("prediction: in a run the measured force is the twin's, and the motion that of the coupled system")
{
    closed_loop loop("ess", stiff_object + with_prediction + overrides{"run.duration_s=10"});
    const rig rig = load_rig("ess", stiff_object);
    const std::complex<double> coupled_per_s = coupled_mode_per_s(rig);
    const double growth_per_s = coupled_per_s.real();
    const double w = coupled_per_s.imag();
    double error_N = 0.0;
    double peak_N = 0.0;
    double off_m = 0.0;
    long running = 0;
    while (loop.tick()) {
        const tick_record &record = loop.app().recorder.tick;
        if (!loop.is_running()) {
            continue;
        }
        const double t = config_period_s(&rig.firmware) * static_cast<double>(running++);
        const double truth_m =
            0.01 * std::exp(growth_per_s * t) * (std::cos(w * t) - growth_per_s / w * std::sin(w * t));
        off_m = std::max(off_m, std::abs(record.manipulator_position_m - truth_m));
        error_N = std::max(error_N, std::abs(record.predicted_error_N));
        peak_N = std::max(peak_N, std::abs(record.force_N));
    }
    REQUIRE(running > 3000);
    REQUIRE(peak_N > 100.0);
    CHECK(error_N < 1e-2 * peak_N); /* the limits round the setpoints off when the swing begins at once */
    CHECK(off_m < 1e-2 * 0.01);
}

TEST_CASE("prediction: a model that is wrong grows as its eigenvalues say")
{
    for (const double stiffness_N_per_m : {30000.0, 90000.0}) {
        for (const double dead_time_ms : {12.25, 22.75}) {
            const overrides own =
                stiff_object + with_prediction +
                overrides{set("prediction.stiffness_N_per_m", stiffness_N_per_m),
                          set("prediction.dead_time_ms", dead_time_ms), "run.duration_s=20",
                          "manipulator.initial_position_m=1e-4", "limits.acceleration_m_per_s2=1e6"};
            CAPTURE(stiffness_N_per_m);
            CAPTURE(dead_time_ms);
            const double predicted_per_s = loop_spectrum(load_rig("ess", own)).growth_per_s;
            closed_loop loop("ess", own);
            const std::vector<double> x = free_motion_m(loop);
            const auto growth = fit_growth(x, 0.0025, 1e-9);
            REQUIRE(growth);
            CHECK(growth->growth_per_s == doctest::Approx(predicted_per_s).epsilon(0.02));
        }
    }
}

TEST_CASE("dissipation: is damping of the manipulator")
{
    const spectrum as_unit = loop_spectrum(load_rig("ess", {"dissipation.damping_N_s_per_m=300"}));
    const rig plain = load_rig("ess");
    const rig damped = load_rig(
        "ess", {set("manipulator.damping_N_s_per_m", plain.firmware.manipulator.damping_N_s_per_m + 300.0)});
    CHECK(as_unit.growth_per_s == doctest::Approx(loop_spectrum(damped).growth_per_s).epsilon(0.02));
    CHECK(as_unit.growth_per_s < loop_spectrum(plain).growth_per_s - 0.3);
}

TEST_CASE("passivity: a controller that follows the measured port takes what the dead time makes")
{
    /* A manipulator so heavy that it swings on, whatever: pi k tau w A^2 a cycle, see energy_account_test. */
    constexpr double w = 2.0 * M_PI;
    constexpr double amplitude_m = 0.05;
    constexpr double stiffness_N_per_m = 20000.0;
    constexpr double mass_kg = 1e7;
    closed_loop loop("ess", {set("manipulator.mass_kg", mass_kg),
                             set("manipulator.stiffness_N_per_m", mass_kg * w * w - stiffness_N_per_m),
                             "manipulator.damping_N_s_per_m=0", set("manipulator.initial_position_m", amplitude_m),
                             "object.mass_kg=0.001", set("object.stiffness_N_per_m", stiffness_N_per_m),
                             "object.damping_N_s_per_m=0", "sensor.stiffness_N_per_m=1e9",
                             "limits.acceleration_m_per_s2=1e6", "run.duration_s=20", "passivity.action=damping",
                             "passivity.credit_J=0.5"});
    double at_first_J = 0.0;
    double taken_J = 0.0;
    double deficit_J = -1.0;
    for (int running = 0; loop.tick();) {
        running += loop.is_running();
        const compensation &units = loop.app().compensation;
        if (running == 2000) {
            at_first_J = units.passivity.taken_J;
        }
        if (running >= 2000 && running <= 4000) {
            taken_J = (units.passivity.taken_J - at_first_J) / 5.0;
            deficit_J = std::max(deficit_J, units.passivity.deficit_J);
        }
    }
    const double delay_s = 1e-3 * (17.5 + 2.5 + 1.25) + 1.4 / (2.0 * M_PI * 20.0);
    const double made_J = M_PI * stiffness_N_per_m * w * delay_s * amplitude_m * amplitude_m;
    CHECK(taken_J == doctest::Approx(made_J).epsilon(0.03));
    CHECK(deficit_J < made_J);
}

TEST_CASE("passivity: the copper sheet does not blow up with either controller, and no more comes back than given")
{
    for (const char *action : {"damping", "tank"}) {
        for (const char *reference : {"zero", "measured"}) {
            CAPTURE(std::string(action));
            CAPTURE(std::string(reference));
            closed_loop loop("concept-copper",
                             {std::string("passivity.action=") + action,
                              std::string("passivity.reference=") + reference, "passivity.credit_J=0.5"});
            double peak_N = 0.0;
            double least_given_J = 0.0;
            double most_in_a_tick_J = 0.0;
            double before_J = 0.0;
            while (loop.tick()) {
                peak_N = std::max(peak_N, std::abs(loop.app().recorder.tick.force_N));
                const double given_J = loop.app().recorder.tick.energy_simulated_port_J;
                least_given_J = std::min(least_given_J, given_J);
                most_in_a_tick_J = std::max(most_in_a_tick_J, std::abs(given_J - before_J));
                before_J = given_J;
            }
            CHECK(loop.is_running());
            CHECK(peak_N < 1000.0); /* without: 15.5 kN */
            /* A damper carries over what it cannot take at once, a tank is never overdrawn but within a tick. */
            if (std::string(reference) == "zero" && std::string(action) == "tank") {
                CHECK(least_given_J > -0.5 - 2.0 * most_in_a_tick_J);
            }
        }
    }
}

TEST_CASE("compensation: settings that cannot work are refused with the key")
{
    const struct {
        const char *setting;
        const char *key;
    } rows[] = {
        {"extrapolation.order=4", "extrapolation.order"},
        {"prediction.error_bandwidth_Hz=201", "prediction.error_bandwidth_Hz"},
        {"adaptive_inverse.tolerance=0.4", "adaptive_inverse.tolerance"},
        {"adaptive_inverse.gain_tolerance=0.5", "adaptive_inverse.gain_tolerance"},
        {"adaptive_inverse.bandwidth_Hz=41", "adaptive_inverse.bandwidth_Hz"},
        {"force_lead.age_ms=3000", "force_lead.enabled"},
        {"prediction.enabled=true", "force_lead.enabled"},
        {"dissipation.damping_N_s_per_m=2e5", "dissipation.damping_N_s_per_m"},
        {"passivity.damping_max_N_s_per_m=2e5", "passivity.damping_max_N_s_per_m"},
        {"dissipation.damping_N_s_per_m=1.58e5", "passivity.damping_max_N_s_per_m"}, /* the two together */
        {"passivity.credit_J=0", "passivity.credit_J"},
        {"extrapolation.delay_ms=1000", "extrapolation.order"},
        {"inverse_filter.enabled=true", "adaptive_inverse.enabled"},
        {"robot.dead_time_ms=3000", "prediction.enabled"},
    };
    for (const auto &row : rows) {
        CAPTURE(row.setting);
        rig rig = load_rig("ess", {"extrapolation.order=3", "passivity.action=damping",
                                   "adaptive_inverse.enabled=true", "robot.transfer_frequency_Hz=12"});
        const bool leads = std::string(row.key) == "force_lead.enabled";
        REQUIRE(!set_value(rig, leads ? "force_lead.enabled" : "prediction.enabled", "true"));
        if (std::string(row.key) == "passivity.credit_J") {
            REQUIRE(!set_value(rig, "passivity.action", "tank"));
        }
        if (std::string(row.key) == "prediction.enabled") {
            rig.firmware.extrapolation.order = 0;
            rig.firmware.passivity.action = PASSIVITY_OFF;
        }
        REQUIRE(!complete_and_check(rig));
        const std::string text(row.setting);
        const std::size_t equals = text.find('=');
        REQUIRE(!set_value(rig, text.substr(0, equals), text.substr(equals + 1)));
        const auto error = complete_and_check(rig);
        REQUIRE(error);
        CHECK(error->key == row.key);
    }
}

} // namespace berth
