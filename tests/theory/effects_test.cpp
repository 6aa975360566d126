/* Effects of the library in the closed loop and in the rig alone, against closed forms. */
#include <array>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <vector>

#include "../../firmware/can/codec.h"
#include "../../firmware/pi.h"
#include "../../sim_hal/effects/active.h"
#include "../../sim_hal/hil/virtual_rig.h"
#include "../../sim_hal/solver/manipulator_steps.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/closed_loop.h"

using namespace berth;

namespace
{

constexpr std::int64_t ms = 1000000;

/* doctest's own Approx takes 1 for a small number. */
double share_off(double value, double expected)
{
    return std::abs(value / expected - 1.0);
}

rig ideal_ess(std::vector<std::string> overrides)
{
    overrides.insert(overrides.end(), {"manipulator.initial_position_m=0", "bus.ideal=true",
                                       "robot.dead_time_ms=2.5", "sensor.delay_ms=0"});
    return load_rig("ess", overrides);
}

hal_frame setpoint(double position_m, std::int64_t time_ns)
{
    berth_can_setpoint_t raw{};
    raw.position_m =
        berth_can_setpoint_position_m_encode(codec_round(position_m, berth_can_setpoint_position_m_decode(1)));
    hal_frame frame{time_ns, BERTH_CAN_SETPOINT_FRAME_ID, HAL_BUS_ROBOT, BERTH_CAN_SETPOINT_LENGTH, 0, 0, {}};
    berth_can_setpoint_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

struct driven_motion {
    std::vector<double> time_s;
    std::vector<double> command_m; /* where the base robot would be, one dead time later */
    std::vector<double> robot_m;
    std::vector<double> low_pass_N; /* as the force leaves it */
};

/* The rig by itself, with a sine for setpoints. */
driven_motion drive(const rig &rig, double amplitude_m, double frequency_Hz, double duration_s)
{
    virtual_rig hardware(rig);
    const std::int64_t period_ns = config_period_ns(&rig.firmware);
    const auto command_m = [&](double time_s) {
        return time_s <= 0.0 ? 0.0 : amplitude_m * std::sin(two_pi * frequency_Hz * time_s);
    };
    driven_motion motion;
    const double dead_time_s = 1e-3 * rig.robot.dead_time_ms;
    for (std::int64_t now_ns = 0; static_cast<double>(now_ns) * 1e-9 < duration_s; now_ns += period_ns) {
        hardware.advance_to(now_ns);
        const double now_s = static_cast<double>(now_ns) * 1e-9;
        motion.time_s.push_back(now_s);
        motion.command_m.push_back(command_m(now_s - dead_time_s));
        motion.robot_m.push_back(hardware.truth().robot_position_m);
        motion.low_pass_N.push_back(hardware.state()(filter_output));
        hardware.receive_from_loop(setpoint(command_m(now_s), now_ns));
    }
    return motion;
}

/* Area of r over u in the last cycle. */
double loop_area(const driven_motion &motion, double frequency_Hz)
{
    const std::size_t count = motion.time_s.size();
    const auto cycle = static_cast<std::size_t>(std::lround(1.0 / frequency_Hz / motion.time_s[1]));
    double area = 0.0;
    for (std::size_t i = count - cycle; i < count; i++) {
        area += 0.5 * (motion.robot_m[i] + motion.robot_m[i - 1]) * (motion.command_m[i] - motion.command_m[i - 1]);
    }
    return std::abs(area);
}

/* Complex amplitude at the frequency over whole cycles at the end. */
std::complex<double> line_of(const std::vector<double> &time_s, const std::vector<double> &values,
                             double frequency_Hz, double cycles)
{
    const auto length = static_cast<std::size_t>(std::lround(cycles / frequency_Hz / time_s[1]));
    std::complex<double> sum = 0.0;
    for (std::size_t i = values.size() - length; i < values.size(); i++) {
        sum += values[i] * std::polar(1.0, -two_pi * frequency_Hz * time_s[i]);
    }
    return 2.0 * sum / static_cast<double>(length);
}

/* The object by itself: the sensor's spring is so soft that it hardly holds it. Position from 0.1 m on at rest. */
std::vector<double> free_object(const std::vector<std::string> &overrides, double duration_s, double step_s)
{
    std::vector<std::string> all{"sensor.stiffness_N_per_m=1e-6", "sensor.damping_ratio=0", "object.mass_kg=100",
                                 "object.damping_N_s_per_m=0", "object.stiffness_N_per_m=3947.8417604357432"};
    all.insert(all.end(), overrides.begin(), overrides.end()); /* 1 Hz */
    virtual_rig hardware(ideal_ess(all));
    beam_state state = hardware.state();
    state(object_position) = 0.1;
    state(second_position) = state(relaxed_position) = 0.1;
    hardware.set_state(state);
    std::vector<double> positions_m;
    for (int i = 0; i * step_s <= duration_s; i++) {
        hardware.advance_to(std::llround(i * step_s * 1e9));
        positions_m.push_back(hardware.state()(object_position));
    }
    return positions_m;
}

std::size_t count_repeats(const std::vector<double> &values)
{
    std::size_t repeats = 0;
    for (std::size_t i = 1; i < values.size(); i++) {
        repeats += values[i] == values[i - 1];
    }
    return repeats;
}

} // namespace

TEST_CASE("effects: backlash is the play operator, loop area b (2 A - b)")
{
    const double amplitude_m = 0.01;
    for (const double backlash_m : {1e-4, 2e-3, 8e-3}) {
        const rig rig = ideal_ess({"robot.backlash_m=" + std::to_string(backlash_m)});
        const double area = loop_area(drive(rig, amplitude_m, 0.5, 6.0), 0.5);
        /* A parallelogram: the output moves by 2 A - b, either way b apart. */
        CHECK(share_off(area, backlash_m * (2.0 * amplitude_m - backlash_m)) < 2e-3);
    }
}

TEST_CASE("effects: gain and deadband of the robot")
{
    const driven_motion scaled = drive(ideal_ess({"robot.gain_error=0.05"}), 0.01, 1.0, 2.0);
    const driven_motion stepped = drive(ideal_ess({"robot.deadband_m=1e-3"}), 0.01, 1.0, 2.0);
    double farthest_m = 0.0;
    for (std::size_t i = 0; i < scaled.time_s.size(); i++) {
        CHECK(std::abs(scaled.robot_m[i] - 1.05 * scaled.command_m[i]) < 1e-10);
        farthest_m = std::max(farthest_m, std::abs(stepped.robot_m[i] - stepped.command_m[i]));
    }
    CHECK(farthest_m <= 1e-3);
    CHECK(farthest_m > 0.9e-3);
}

TEST_CASE("effects: a lag of the robot and of the sensor turns the phase by atan(w tau)")
{
    const double frequency_Hz = 4.0;
    const double tau_s = 0.02;
    const std::complex<double> expected = 1.0 / std::complex<double>(1.0, two_pi * frequency_Hz * tau_s);
    const driven_motion lagging = drive(ideal_ess({"robot.lag_ms=20"}), 0.01, frequency_Hz, 3.0);
    const std::complex<double> robot = line_of(lagging.time_s, lagging.robot_m, frequency_Hz, 4.0) /
                                       line_of(lagging.time_s, lagging.command_m, frequency_Hz, 4.0);
    CHECK(std::abs(robot - expected) < 1e-3); /* of the lines between setpoints, (w T)^2 / 12 */

    std::complex<double> force[2];
    for (int i = 0; i < 2; i++) {
        const rig rig = ideal_ess({i == 0 ? "sensor.lag_ms=0" : "sensor.lag_ms=20"});
        virtual_rig hardware(rig);
        std::vector<double> time_s;
        std::vector<double> force_N;
        for (std::int64_t n = 0; n < 4800; n++) {
            const std::int64_t now_ns = n * 5 * ms / 2;
            hardware.advance_to(now_ns);
            time_s.push_back(static_cast<double>(now_ns) * 1e-9);
            force_N.push_back(hardware.truth().measured_force_N);
            hardware.receive_from_loop(setpoint(1e-3 * std::sin(two_pi * frequency_Hz * time_s.back()), now_ns));
        }
        force[i] = line_of(time_s, force_N, frequency_Hz, 4.0);
    }
    CHECK(std::abs(force[1] / force[0] - expected) < 2e-4);
}

TEST_CASE("effects: the periodic error of the robot repeats with its pitch")
{
    const driven_motion motion =
        drive(ideal_ess({"robot.periodic_error_m=1e-4", "robot.periodic_error_pitch_m=0.004",
                         "robot.periodic_error_phase_rad=0.5"}),
              0.01, 1.0, 2.0);
    for (std::size_t i = 0; i < motion.time_s.size(); i++) {
        const double u = motion.command_m[i];
        CHECK(std::abs(motion.robot_m[i] - (u + 1e-4 * std::sin(two_pi * u / 0.004 + 0.5))) < 1e-10);
    }
}

TEST_CASE("effects: dry friction takes 4 Fc / k from the amplitude in each cycle")
{
    const double stiffness = 3947.8417604357432;
    const std::vector<double> motion = free_object({"object.coulomb_friction_N=10"}, 5.0, 1.0);
    for (std::size_t cycle = 1; cycle < motion.size(); cycle++) {
        const double expected_m = 0.1 - static_cast<double>(cycle) * 4.0 * 10.0 / stiffness;
        CHECK(share_off(motion[cycle], expected_m) < 2e-3);
    }
}

TEST_CASE("effects: a cubic spring swings with Duffing's frequency")
{
    /* k3 A^2 = 0.4 k: w = w0 (1 + 3/8 e - 21/256 e^2 + 81/2048 e^3 - ...), e = 0.4 */
    const std::vector<double> motion = free_object({"object.cubic_stiffness_N_per_m3=157913.67"}, 8.0, 1e-3);
    std::vector<double> crossings_s;
    for (std::size_t i = 1; i < motion.size(); i++) {
        if (motion[i - 1] > 0.0 && motion[i] <= 0.0) {
            crossings_s.push_back((static_cast<double>(i) - motion[i] / (motion[i] - motion[i - 1])) * 1e-3);
        }
    }
    const double frequency_Hz =
        static_cast<double>(crossings_s.size() - 1) / (crossings_s.back() - crossings_s.front());
    /* exact: T = 4 K(m) / sqrt(w0^2 + k3/m A^2), m = e / (2 (1 + e)) */
    const double e = 0.4;
    const double period_s =
        4.0 * std::comp_ellint_1(std::sqrt(e / (2.0 * (1.0 + e)))) / (two_pi * std::sqrt(1.0 + e));
    CHECK(share_off(frequency_Hz, 1.0 / period_s) < 2e-4);
}

TEST_CASE("effects: a gap in the object's spring lengthens the period by the time of free flight")
{
    /* Half a cycle: k d^2/2 on either side, and b at the velocity w (A - b/2). */
    const double half_m = 0.01;
    const std::vector<double> motion = free_object({"object.backlash_m=0.02"}, 10.0, 1e-3);
    std::vector<double> crossings_s;
    for (std::size_t i = 1; i < motion.size(); i++) {
        if (motion[i - 1] > 0.0 && motion[i] <= 0.0) {
            crossings_s.push_back((static_cast<double>(i) - motion[i] / (motion[i] - motion[i - 1])) * 1e-3);
        }
    }
    const double period_s = (crossings_s.back() - crossings_s.front()) / static_cast<double>(crossings_s.size() - 1);
    const double expected_s = 1.0 + 4.0 * half_m / (two_pi * (0.1 - half_m));
    CHECK(share_off(period_s, expected_s) < 1e-3);
}

TEST_CASE("effects: a second mass swings with the two frequencies of the coupled bodies")
{
    /* m2 = m/10 tuned to the same 1 Hz: w^4 - (2 + mu) w^2 + 1 = 0 in units of w0. */
    const std::vector<double> motion = free_object(
        {"object.second_mass_kg=10", "object.second_frequency_Hz=1", "object.second_damping_ratio=0"}, 20.0, 2.5e-3);
    const double mu = 0.1;
    const double root = std::sqrt((2.0 + mu) * (2.0 + mu) - 4.0);
    const double low_Hz = std::sqrt(0.5 * (2.0 + mu - root));
    const double high_Hz = std::sqrt(0.5 * (2.0 + mu + root));
    /* x = a1 cos w1 t + a2 cos w2 t with a1 + a2 = 0.1, both bodies at rest at 0.1 m at first. */
    const double low = low_Hz * low_Hz;
    const double high = high_Hz * high_Hz;
    const double a_low = 0.1 * high * (1.0 - low) / (high - low);
    double worst_m = 0.0;
    for (std::size_t i = 0; i < motion.size(); i++) {
        const double t = 2.5e-3 * static_cast<double>(i);
        const double both = a_low * std::cos(two_pi * low_Hz * t) + (0.1 - a_low) * std::cos(two_pi * high_Hz * t);
        worst_m = std::max(worst_m, std::abs(motion[i] - both));
    }
    MESSAGE("largest difference " << worst_m << " m of 0.1 m over 20 s");
    CHECK(worst_m < 1e-6);
}

TEST_CASE("effects: a manipulator with Stribeck friction sticks below Fc + Fs, and slides as fast as its law says")
{
    /* A constant force, no spring: D v + Fc + Fs exp(-(v/vs)^2) = F. */
    const auto velocity_m_per_s = [](double force_N, double presliding_m) {
        rig rig = ideal_ess({"manipulator.stiffness_N_per_m=0", "manipulator.damping_N_s_per_m=100",
                             "manipulator.mass_kg=50", "manipulator.coulomb_friction_N=6",
                             "manipulator.stribeck_friction_N=4", "manipulator.stribeck_velocity_m_per_s=0.05"});
        set_number(rig, "manipulator.coulomb_presliding_m", presliding_m);
        manipulator_steps body(rig, 2.5e-3, 4);
        body.start(Eigen::Vector2d::Zero());
        for (int tick = 0; tick < 4000; tick++) {
            body.advance({0.0, 0.0, force_N, 0.0});
        }
        return body.state()(1);
    };
    for (const double presliding_m : {0.0, 1e-6}) {
        CAPTURE(presliding_m);
        CHECK(std::abs(velocity_m_per_s(9.8, presliding_m)) < 1e-6);
        for (const double force_N : {10.5, 15.0}) {
            const double v = velocity_m_per_s(force_N, presliding_m);
            CHECK(v > 0.005);
            const double law_N = 100.0 * v + 6.0 + 4.0 * std::exp(-v * v / (0.05 * 0.05));
            CHECK(law_N == doctest::Approx(force_N).epsilon(1e-6));
        }
    }
}

TEST_CASE("effects: an object that relaxes swings as its cubic says, by each solver")
{
    /* m x'' + k x + z = 0, z' = kR x' - z/tau: m s^3 + m/tau s^2 + (k + kR) s + k/tau = 0, from rest at 0.1 m with z
     * = 0. The roots by their own residues: X(s) = 0.1 (m s^2 + m/tau s + kR) / (cubic). */
    using complex = std::complex<double>;
    const double m = 100.0, k = 3947.8417604357432, k_R = 1500.0, tau = 0.08;
    const auto cubic = [&](complex s) { return m * s * s * s + m / tau * s * s + (k + k_R) * s + k / tau; };
    std::array<complex, 3> roots{complex(-10.0, 0.0), complex(-0.5, 6.5), complex(-0.5, -6.5)};
    for (int round = 0; round < 200; round++) { /* Durand and Kerner */
        for (std::size_t i = 0; i < 3; i++) {
            roots[i] -= cubic(roots[i]) / m / ((roots[i] - roots[(i + 1) % 3]) * (roots[i] - roots[(i + 2) % 3]));
        }
    }
    const std::vector<std::string> relaxing{"object.relaxation_stiffness_N_per_m=1500",
                                            "object.relaxation_time_ms=80"};
    const std::vector<std::string> with_stages{relaxing[0], relaxing[1], "object.cubic_stiffness_N_per_m3=1e-9"};
    for (const auto &overrides : {relaxing, with_stages}) {
        const std::vector<double> motion = free_object(overrides, 5.0, 2.5e-3);
        double worst_m = 0.0;
        for (std::size_t n = 0; n < motion.size(); n++) {
            const double t = 2.5e-3 * static_cast<double>(n);
            complex x = 0.0;
            for (const complex &s : roots) {
                const complex slope = 3.0 * m * s * s + 2.0 * m / tau * s + k + k_R;
                x += 0.1 * (m * s * s + m / tau * s + k_R) / slope * std::exp(s * t);
            }
            worst_m = std::max(worst_m, std::abs(motion[n] - x.real()));
        }
        MESSAGE("largest difference " << worst_m << " m of 0.1 m over 5 s");
        CHECK(worst_m < 2e-6);
    }
}

TEST_CASE("effects: a tool behind the sensor adds its mass to the force of an even swing")
{
    /* mT s^2 times the low-pass, in N per m of the robot. */
    const double frequency_Hz = 2.0;
    const double w = two_pi * frequency_Hz;
    const std::string smooth = "robot.transfer_frequency_Hz=30"; /* no corners that the samples would see */
    const rig rig = ideal_ess({smooth});
    const auto swing = [&](const berth::rig &of) {
        const driven_motion motion = drive(of, 0.01, frequency_Hz, 20.0);
        return line_of(motion.time_s, motion.low_pass_N, frequency_Hz, 8.0) /
               line_of(motion.time_s, motion.robot_m, frequency_Hz, 8.0);
    };
    const std::complex<double> added = swing(ideal_ess({smooth, "sensor.tool_mass_kg=30"})) - swing(rig);
    const double w_L = two_pi * rig.sensor.low_pass_frequency_Hz;
    const std::complex<double> s(0.0, w);
    const std::complex<double> low_pass =
        w_L * w_L / (s * s + 2.0 * rig.sensor.low_pass_damping_ratio * w_L * s + w_L * w_L);
    CHECK(std::abs(added / (30.0 * s * s * low_pass) - 1.0) < 1e-3);
}

TEST_CASE("effects: hysteresis loses 4 Fh A a cycle where the way is long")
{
    const double stiffness = 3947.8417604357432;
    const std::vector<double> motion =
        free_object({"object.hysteresis_force_N=10", "object.hysteresis_length_m=1e-4"}, 3.0, 1.0);
    for (std::size_t cycle = 1; cycle < motion.size(); cycle++) {
        const double coulomb_m = 0.1 - static_cast<double>(cycle) * 4.0 * 10.0 / stiffness;
        CHECK(share_off(motion[cycle], coulomb_m) < 5e-3);
    }
}

TEST_CASE("effects: a spring that drifts shortens the period like 1/sqrt(k)")
{
    const std::vector<double> motion = free_object({"object.stiffness_drift_per_s=0.01"}, 60.0, 1e-3);
    double phase = 0.0; /* of the WKB solution: the integral of sqrt(1 + r t) cycles */
    const auto cycles = [](double t) { return (std::pow(1.0 + 0.01 * t, 1.5) - 1.0) / 0.015; };
    double worst = 0.0;
    for (std::size_t i = 1; i < motion.size(); i++) {
        if (motion[i - 1] > 0.0 && motion[i] <= 0.0) {
            const double t = (static_cast<double>(i) - motion[i] / (motion[i] - motion[i - 1])) * 1e-3;
            phase = cycles(t);
            worst = std::max(worst, std::abs(phase - std::floor(phase) - 0.25));
        }
    }
    CHECK(phase > 60.0);
    CHECK(worst < 5e-3);
}

TEST_CASE("effects: the grip lets go where it has to pull more than it can")
{
    /* A hard pull, then the robot stands; the object flies on. */
    const rig rig = ideal_ess({"object.grip_force_N=5", "object.stiffness_N_per_m=0", "object.damping_N_s_per_m=0"});
    virtual_rig hardware(rig);
    double least_N = 0.0;
    double time_s = 0.0;
    for (std::int64_t n = 0; n < 400; n++) {
        const std::int64_t now_ns = n * 5 * ms / 2;
        hardware.advance_to(now_ns);
        time_s = static_cast<double>(now_ns) * 1e-9;
        least_N = std::min(least_N, hardware.truth().spring_force_N);
        hardware.receive_from_loop(setpoint(-0.5 * 1.0 * time_s * time_s, now_ns)); /* 1 m/s^2: 100 N */
    }
    CHECK(hardware.truth().object_position_m > hardware.truth().robot_position_m + 0.1);
    CHECK(hardware.truth().spring_force_N == 0.0);
}

TEST_CASE("effects: electronics of the sensor")
{
    const std::vector<double> still = [] {
        closed_loop loop(ideal_ess({"sensor.drift_N_per_s=2", "sensor.periodic_N=1",
                                    "sensor.periodic_frequency_Hz=5", "sensor.bias_N=3", "run.duration_s=0.09"}));
        std::vector<double> force_N;
        while (loop.tick()) {
            force_N.push_back(loop.app().recorder.tick.force_N);
        }
        return force_N;
    }();
    REQUIRE(still.size() > 20);
    for (std::size_t n = 0; n < still.size(); n++) {
        const double t = 2.5e-3 * static_cast<double>(n);
        CHECK(std::abs(still[n] - (3.0 + 2.0 * t + std::sin(two_pi * 5.0 * t))) < 1e-6);
    }
}

TEST_CASE("effects: what is lost is lost as often as told, and spikes come as often")
{
    const double p = 0.05;
    const double ticks = 20000.0;
    const double four_sigma = 4.0 * std::sqrt(ticks * p * (1.0 - p));
    closed_loop loop(ideal_ess({"loop.lost_sample_probability=0.05", "sensor.noise_N=1e-3",
                                "robot.feedback_noise_m=1e-8", "run.duration_s=50"}));
    std::vector<double> force_N;
    std::vector<double> robot_m;
    while (loop.tick()) {
        force_N.push_back(loop.app().recorder.tick.force_N);
        robot_m.push_back(loop.app().recorder.tick.robot_position_m);
    }
    std::size_t apart = 0;
    for (std::size_t i = 1; i < force_N.size(); i++) {
        apart += (force_N[i] == force_N[i - 1]) != (robot_m[i] == robot_m[i - 1]);
    }
    CHECK(std::abs(static_cast<double>(count_repeats(force_N)) - p * ticks) < four_sigma);
    CHECK(apart < 30); /* two samples in 1e4 steps of the wire are alike by chance, positions seldom */

    closed_loop spiky(
        ideal_ess({"sensor.spike_probability=0.05", "sensor.spike_N=10", "run.duration_s=50", "run.release_s=100"}));
    double spikes = 0.0;
    double sum_N = 0.0;
    while (spiky.tick()) {
        const double size_N = std::abs(spiky.app().recorder.tick.force_N);
        spikes += size_N > 0.5;
        sum_N += size_N;
    }
    CHECK(std::abs(spikes - p * ticks) < four_sigma);
    CHECK(share_off(sum_N / spikes, 10.0) < 0.02);
}

TEST_CASE("effects: noise of the robot's report has the size it is given, and moves nothing")
{
    closed_loop noisy(ideal_ess({"robot.feedback_noise_m=1e-6", "run.duration_s=20"}));
    closed_loop quiet(ideal_ess({"run.duration_s=20"}));
    double square = 0.0;
    double count = 0.0;
    while (noisy.tick() && quiet.tick()) {
        CHECK(noisy.app().recorder.tick.command_position_m == quiet.app().recorder.tick.command_position_m);
        const double off_m = noisy.app().recorder.tick.robot_position_m - quiet.app().recorder.tick.robot_position_m;
        square += off_m * off_m;
        count += 1.0;
    }
    CHECK(share_off(std::sqrt(square / count), 1e-6) < 0.04);
}

TEST_CASE("effects: the loop's growth with a gain in it is that of its eigenvalues")
{
    for (const char *const gain : {"robot.gain_error=0.1", "sensor.gain_error=-0.2"}) {
        const rig rig = load_rig("ess", {gain, "run.duration_s=60"});
        closed_loop loop(rig);
        const std::vector<double> motion = free_motion_m(loop);
        const auto fit = fit_growth(motion, config_period_s(&rig.firmware), 1e-8);
        REQUIRE(fit);
        const double expected_per_s = loop_spectrum(rig).growth_per_s;
        CHECK(share_off(expected_per_s, loop_spectrum(load_rig("ess", {})).growth_per_s) > 5e-3);
        CHECK(share_off(fit->growth_per_s, expected_per_s) < 1e-4);
    }
}

TEST_CASE("effects: an effect too small to act leaves the loop as it is")
{
    /* The steps with effects against the exact solver. */
    closed_loop exact("ess", {"run.duration_s=10"});
    closed_loop stepped("ess", {"run.duration_s=10", "object.cubic_stiffness_N_per_m3=1e-9"});
    double worst_m = 0.0;
    while (exact.tick() && stepped.tick()) {
        worst_m = std::max(worst_m, std::abs(exact.app().recorder.tick.manipulator_position_m -
                                             stepped.app().recorder.tick.manipulator_position_m));
    }
    CHECK(worst_m < 1e-10);
}

TEST_CASE("effects: what has no linearisation says so")
{
    CHECK(left_out_when_small(load_rig("ess", {"robot.backlash_m=1e-4"})).size() == 1);
    CHECK(left_out_when_small(load_rig("ess", {"object.cubic_stiffness_N_per_m3=1"})).empty());
    CHECK_THROWS_AS(virtual_rig(load_rig("ess", {"robot.backlash_m=1e-4", "solver.kind=cvode"})), input_error);
}
