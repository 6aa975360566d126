/* A dead time tau in a spring k gives pi k tau w A^2 to whoever moves it by A sin wt, every cycle (Horiuchi 1999).
 * Here the setpoints are prescribed, so nothing can go unstable, and the energy is what the software would book:
 * the force that it holds during a tick times the way that its own motion makes in that tick. */
#include <cmath>
#include <complex>
#include <doctest/doctest.h>

#include "../../firmware/can/codec.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/sim_hal.h"

namespace berth
{

namespace
{

constexpr double stiffness_N_per_m = 20000.0;

/* A spring and hardly anything else: a gram behind a sensor that is 5000 times stiffer. */
rig spring_rig(std::vector<std::string> overrides)
{
    for (const char *fixed :
         {"object.mass_kg=0.001", "object.stiffness_N_per_m=20000", "object.damping_N_s_per_m=0",
          "sensor.stiffness_N_per_m=1e8", "manipulator.initial_position_m=0", "run.duration_s=1000"}) {
        overrides.push_back(fixed);
    }
    return load_rig("ess", overrides);
}

hal_frame setpoint(double position_m, const hal_tick &tick)
{
    berth_can_setpoint_t raw{};
    raw.position_m =
        berth_can_setpoint_position_m_encode(codec_round(position_m, berth_can_setpoint_position_m_decode(1)));
    raw.counter = static_cast<std::uint8_t>(tick.index);
    hal_frame frame{
        tick.scheduled_ns, BERTH_CAN_SETPOINT_FRAME_ID, HAL_BUS_ROBOT, BERTH_CAN_SETPOINT_LENGTH, 0, 0, {}};
    berth_can_setpoint_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

/* Takes what has arrived; the newest force, in N, is kept. */
void receive_force(struct hal *hal, double &force_N)
{
    hal_frame frame;
    while (hal_can_receive(hal, HAL_BUS_ROBOT, &frame) == HAL_OK) {
    }
    while (hal_can_receive(hal, HAL_BUS_SENSOR, &frame) == HAL_OK) {
        berth_can_force_t raw;
        REQUIRE(berth_can_force_unpack(&raw, frame.data, frame.length) >= 0);
        force_N = berth_can_force_force_n_decode(raw.force_n);
    }
}

/* Energy in J that the loop gives to the prescribed motion per cycle of `ticks` ticks, once it has settled. */
double energy_per_cycle_J(const rig &rig, double amplitude_m, std::int64_t ticks)
{
    constexpr std::int64_t settle = 3;
    constexpr std::int64_t cycles = 4;
    struct hal *hal = sim_open(rig);
    const auto position_m = [&](std::int64_t n) {
        return amplitude_m * std::sin(2.0 * M_PI * static_cast<double>(n % ticks) / static_cast<double>(ticks));
    };
    double energy_J = 0.0;
    double force_N = 0.0;
    for (std::int64_t n = 0; n < ticks * (settle + cycles); n++) {
        hal_tick tick;
        REQUIRE(hal_wait_tick(hal, &tick) == HAL_OK);
        receive_force(hal, force_N);
        const hal_frame frame = setpoint(position_m(n), tick);
        REQUIRE(hal_can_send(hal, &frame) == HAL_OK);
        if (n >= ticks * settle) {
            energy_J -= force_N * (position_m(n + 1) - position_m(n));
        }
    }
    CHECK(hal_close(hal) == HAL_OK);
    return energy_J / static_cast<double>(cycles);
}

struct energy_case {
    std::string what;
    std::vector<std::string> overrides;
    double dead_time_s; /* T_R + T_S + T/2 of the held force, + T/2 where the position is held as well */
    int low_pass_order; /* of f_L = 20 Hz, zeta_L = 0.7 */
    std::int64_t rate_Hz = 400;
};

std::complex<double> low_pass(int order, double w)
{
    const std::complex<double> s(0.0, w / (2.0 * M_PI * 20.0));
    return order == 2 ? 1.0 / (s * s + 1.4 * s + 1.0) : order == 1 ? 1.0 / (s + 1.0) : 1.0;
}

/* Mean delay of the low-pass: what is left of its phase at low frequency. */
double low_pass_delay_s(int order)
{
    return (order == 2 ? 2.0 * 0.7 : order == 1 ? 1.0 : 0.0) / (2.0 * M_PI * 20.0);
}

const energy_case energy_cases[] = {
    {"400 Hz, 20 ms", {"sensor.low_pass_order=0"}, 17.5e-3 + 2.5e-3 + 1.25e-3, 0},
    {"400 Hz, half", {"sensor.low_pass_order=0", "robot.dead_time_ms=7.5"}, 7.5e-3 + 2.5e-3 + 1.25e-3, 0},
    {"between ticks", {"sensor.low_pass_order=0", "robot.dead_time_ms=11.3"}, 11.3e-3 + 2.5e-3 + 1.25e-3, 0},
    /* The sample waits for its tick: 4.1 ms count as 5. */
    {"slow sensor", {"sensor.low_pass_order=0", "sensor.delay_ms=4.1"}, 17.5e-3 + 5e-3 + 1.25e-3, 0},
    {"low-pass of order 1", {"sensor.low_pass_order=1"}, 17.5e-3 + 2.5e-3 + 1.25e-3, 1},
    {"low-pass of order 2", {}, 17.5e-3 + 2.5e-3 + 1.25e-3, 2},
    {"held position", {"robot.interpolation=hold"}, 17.5e-3 + 1.25e-3 + 2.5e-3 + 1.25e-3, 2},
    {"1 kHz",
     {"sensor.low_pass_order=0", "loop.rate_Hz=1000", "robot.dead_time_ms=3", "sensor.delay_ms=1"},
     3e-3 + 1e-3 + 0.5e-3,
     0,
     1000},
};

/* The law without the approximation sin wt = wt, and with sensor and object spring in series. */
double exact_energy_J(const rig &rig, const energy_case &c, double w, double amplitude_m)
{
    const double series_N_per_m = 1.0 / (1.0 / stiffness_N_per_m + 1.0 / rig.sensor.stiffness_N_per_m);
    const std::complex<double> transfer =
        std::polar(series_N_per_m, -w * c.dead_time_s) * low_pass(c.low_pass_order, w);
    return -M_PI * transfer.imag() * amplitude_m * amplitude_m;
}

/* What sampling leaves between that and the loop, relative: (w T)^2 for straight lines and held values in place of
 * sines; the sensor's damper, which feels the corner of the line at the very instant of a sample; for a held
 * position, its steps as the low-pass lets them through at 400 Hz and sampling folds them back. */
double left_over(const rig &rig, const energy_case &c, double w)
{
    const double period_s = 1.0 / static_cast<double>(c.rate_Hz);
    const double corner = rig.sensor_damping_N_s_per_m() * w * w * period_s / stiffness_N_per_m;
    const double images = rig.robot.interpolation == interpolation::hold ? 1e-4 : 1e-5;
    return 0.2 * w * w * period_s * period_s + (c.low_pass_order == 0 ? 1.2 * corner : 0.0) + images;
}

} // namespace

TEST_CASE("a dead time in a spring gives pi k tau w A^2 a cycle")
{
    for (const energy_case &c : energy_cases) {
        const rig rig = spring_rig(c.overrides);
        REQUIRE(rig.firmware.loop.rate_Hz == c.rate_Hz);
        for (const double amplitude_m : {0.5e-3, 10e-3}) {
            for (const double frequency_Hz : {0.25, 0.5, 1.0}) {
                const std::int64_t ticks = std::llround(static_cast<double>(c.rate_Hz) / frequency_Hz);
                const double w = 2.0 * M_PI * frequency_Hz;
                const double tau_s = c.dead_time_s + low_pass_delay_s(c.low_pass_order);
                CAPTURE(c.what);
                CAPTURE(amplitude_m);
                CAPTURE(frequency_Hz);
                const double energy_J = energy_per_cycle_J(rig, amplitude_m, ticks);

                /* The law holds to (w tau)^2 / 6: within its 1 % where w tau is below 0.2. */
                const double law_J = M_PI * stiffness_N_per_m * tau_s * w * amplitude_m * amplitude_m;
                if (w * tau_s < 0.2) {
                    CHECK(std::abs(energy_J / law_J - 1.0) < 0.01);
                }
                CHECK(std::abs(energy_J / exact_energy_J(rig, c, w, amplitude_m) - 1.0) < left_over(rig, c, w));
            }
        }
    }
}

/* The law is checked where it holds; this makes sure that the cases above do not all lie outside. */
TEST_CASE("the energy grows in proportion to dead time and frequency, and with the square of the amplitude")
{
    const rig slow = spring_rig({"sensor.low_pass_order=0", "robot.dead_time_ms=6.25"}); /* 10 ms in all */
    const rig slower = spring_rig({"sensor.low_pass_order=0", "robot.dead_time_ms=16.25"});
    const double once_J = energy_per_cycle_J(slow, 1e-3, 1600);
    CHECK(energy_per_cycle_J(slower, 1e-3, 1600) / once_J == doctest::Approx(2.0).epsilon(1e-3));
    CHECK(energy_per_cycle_J(slow, 1e-3, 800) / once_J == doctest::Approx(2.0).epsilon(1e-3));
    CHECK(energy_per_cycle_J(slow, 2e-3, 1600) / once_J == doctest::Approx(4.0).epsilon(1e-5));
}

} // namespace berth
