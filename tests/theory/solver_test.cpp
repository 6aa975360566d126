/* The two solvers against each other, and the fast one against equations written a second time. */
#include <array>
#include <cmath>
#include <cstdio>
#include <doctest/doctest.h>

#include "../../firmware/can/codec.h"
#include "../../sim_hal/hil/random.h"
#include "../support/closed_loop.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

enum signal { robot_place, object_place, object_speed, spring_force, measured_force, signal_count };
const std::string signal_names[] = {"robot position", "object position", "object velocity", "spring force",
                                    "measured force"};
using signals = std::array<double, signal_count>;

signals signals_of(const rig_truth &truth)
{
    return {truth.robot_position_m, truth.object_position_m, truth.object_velocity_m_per_s, truth.spring_force_N,
            truth.measured_force_N};
}

/* Largest difference of each signal over the run, relative to its largest value. */
class comparison
{
  public:
    void add(const signals &a, const signals &b)
    {
        for (std::size_t i = 0; i < signal_count; i++) {
            peak_[i] = std::max(peak_[i], std::abs(a[i]));
            difference_[i] = std::max(difference_[i], std::abs(a[i] - b[i]));
        }
    }
    double relative(int i) const { return difference_[i] / peak_[i]; }
    double absolute(int i) const { return difference_[i]; }

  private:
    signals peak_{};
    signals difference_{};
};

/* The rig as the fast solver has it closes the loop; the same rig with CVODE gets the very same frames. */
comparison same_frames(const std::string &name, const std::vector<std::string> &overrides = {})
{
    rig rig = load_rig(name, overrides);
    struct hal *hal = sim_open(rig);
    app app;
    app_start(&app, &rig.firmware);
    rig.solver.kind = solver_kind::cvode;
    virtual_rig listener(rig);
    comparison result;
    tick_input in{};
    tick_output out;
    while (hal_wait_tick(hal, &in.tick) == HAL_OK) {
        listener.advance_to(in.tick.scheduled_ns);
        result.add(signals_of(listener.truth()), signals_of(sim_rig(hal).truth()));
        in.frame_count = 0;
        hal_frame unread;
        for (const hal_bus bus : {HAL_BUS_SENSOR, HAL_BUS_ROBOT}) {
            while (hal_can_receive(hal, bus, &in.frames[in.frame_count]) == HAL_OK) {
                in.frame_count++;
            }
            while (listener.bus(bus).receive(in.tick.scheduled_ns, unread)) {
            }
        }
        hal_gpio_get(hal, HAL_LINE_EMERGENCY_STOP, &in.emergency_stop);
        hal_gpio_get(hal, HAL_LINE_ENABLE, &in.enable);
        app_step(&app, &in, &out);
        for (uint32_t i = 0; i < out.frame_count; i++) {
            hal_can_send(hal, &out.frames[i]);
            listener.receive_from_loop(out.frames[i]);
        }
    }
    CHECK(hal_close(hal) == HAL_OK);
    return result;
}

void check_below(const comparison &result, double bound)
{
    for (int i = 0; i < signal_count; i++) {
        CAPTURE(signal_names[i]);
        CHECK(result.relative(i) < bound);
    }
}

std::string figures(const comparison &result)
{
    std::string text;
    for (int i = object_place; i < signal_count; i++) {
        char part[64];
        std::snprintf(part, sizeof part, "%s%s %.1e", i > object_place ? ", " : "", signal_names[i].c_str(),
                      result.relative(i));
        text += part;
    }
    return text;
}

} // namespace

TEST_CASE("the solvers agree to 1e-8 on the linear rig over 60 s")
{
    for (const std::string rig : {"ess", "ess-50hz", "ess-half-dead-time", "ess-beam"}) {
        CAPTURE(rig);
        check_below(same_frames(rig), 1e-8);
    }
}

TEST_CASE("the solvers agree with transfer behaviour, hold and low-passes of order 0 and 1")
{
    const std::vector<std::string> variants[] = {
        {"robot.transfer_frequency_Hz=8"},
        {"robot.interpolation=hold", "robot.dead_time_ms=17.3"},
        {"sensor.low_pass_order=0", "manipulator.damping_N_s_per_m=2000"},
        {"sensor.low_pass_order=1"},
        {"sensor.sample_phase_ms=1.1", "robot.dead_time_ms=16.123457"},
    };
    for (std::vector<std::string> overrides : variants) {
        CAPTURE(overrides.front());
        overrides.push_back("run.duration_s=10");
        check_below(same_frames("ess", overrides), 1e-8);
    }
}

TEST_CASE("the solvers agree on a beam, with any number of modes")
{
    const std::vector<std::string> variants[] = {
        {"object.modes=8", "robot.transfer_frequency_Hz=8"},
        {"object.modes=2", "robot.interpolation=hold", "robot.dead_time_ms=17.3"},
        {"object.modes=5", "object.beam_root_stiffness_N_m_per_rad=1e5", "sensor.low_pass_order=1"},
    };
    for (std::vector<std::string> overrides : variants) {
        CAPTURE(overrides.front());
        overrides.push_back("run.duration_s=10");
        check_below(same_frames("ess-beam", overrides), 1e-8);
    }
}

/* In a closed loop the solvers' last digits decide now and then on the last step of a setpoint frame, 10 pm: 2e-4 N
 * behind the sensor spring, which is 3e-6 of its largest force. Positions agree all the same. */
TEST_CASE("the solvers agree in the closed loop up to the steps of the setpoint frame")
{
    closed_loop fast("ess", {"solver.kind=fast"});
    closed_loop cvode("ess", {"solver.kind=cvode"});
    comparison result;
    while (fast.tick() && cvode.tick()) {
        result.add(signals_of(fast.truth()), signals_of(cvode.truth()));
    }
    const double step_N = berth_can_setpoint_position_m_decode(1) * load_rig("ess").sensor.stiffness_N_per_m;
    CHECK(result.relative(robot_place) < 1e-8);
    CHECK(result.relative(object_place) < 1e-8);
    CHECK(result.absolute(spring_force) < 8.0 * step_N); /* a few steps at once ring in the sensor spring */
    CHECK(result.absolute(measured_force) < step_N);
}

/* The fast solver finds the instant of contact to 1 ns. There foam takes its damping force of 7 N at once, 7e-9 m/s
 * on the tool of 1 kg, and CVODE steps across the corner within its tolerance. */
TEST_CASE("the difference of the solvers where contact is involved")
{
    const comparison foam = same_frames("concept-foam");
    const comparison copper = same_frames("concept-copper");
    MESSAGE("solvers with contact, foam: ", figures(foam));
    MESSAGE("solvers with contact, copper: ", figures(copper));
    check_below(foam, 1e-6);
    check_below(copper, 1e-7);
}

namespace
{

/* The gripped rig written a second time. Jumps of the reference need no impulse here: the object's velocity and the
 * low-pass are measured from what the sensor's damper has passed on, d_S r, so that r' never appears.
 *     p = m x' - d_S r,  q = y' - w^2 d_S r (order 2),  q = y - w d_S r (order 1); r from G_R or the reference. */
class second_opinion
{
  public:
    explicit second_opinion(const rig &rig) : rig_(rig)
    {
        reference_m_ = rig.firmware.manipulator.initial_position_m;
        const double k_S = rig.sensor.stiffness_N_per_m;
        const double x = k_S / (k_S + rig.object.stiffness_N_per_m) * reference_m_;
        state_ = {reference_m_, 0.0L, x, -damping() * reference_m_, k_S * (reference_m_ - x), 0.0L};
        const long double w = low_pass_w();
        if (rig.sensor.low_pass_order == 2) {
            state_[5] = -w * w * damping() * reference_m_;
        } else if (rig.sensor.low_pass_order == 1) {
            state_[4] -= w * damping() * reference_m_;
        }
    }

    void jump_to(double reference_m) { reference_m_ = reference_m; }

    /* Taylor series of order 20 in short steps. */
    void advance(double slope_m_per_s, std::int64_t duration_ns)
    {
        constexpr int steps = 40;
        const long double h = 1e-9L * static_cast<long double>(duration_ns) / steps;
        for (int i = 0; i < steps; i++) {
            step(slope_m_per_s, h);
        }
    }

    signals truth(double slope_m_per_s) const
    {
        const bool lags = rig_.has_transfer_behaviour();
        const long double r = lags ? state_[0] : reference_m_;
        const long double v_r = lags ? state_[1] : slope_m_per_s;
        const long double v = (state_[3] + damping() * r) / rig_.object.mass_kg;
        const long double force = rig_.sensor.stiffness_N_per_m * (r - state_[2]) + damping() * (v_r - v);
        const long double measured = rig_.sensor.low_pass_order == 2   ? state_[4]
                                     : rig_.sensor.low_pass_order == 1 ? state_[4] + low_pass_w() * damping() * r
                                                                       : force;
        return {static_cast<double>(r), static_cast<double>(state_[2]), static_cast<double>(v),
                static_cast<double>(force), static_cast<double>(measured)};
    }

  private:
    using vector = std::array<long double, 6>; /* r, r', x, p, y or q, q */

    long double damping() const { return rig_.sensor_damping_N_s_per_m(); }
    long double low_pass_w() const { return 2.0L * M_PIl * rig_.sensor.low_pass_frequency_Hz; }

    /* `u` is the reference, or its derivatives when Taylor coefficients are made; everything is linear in both. */
    vector rate(const vector &s, long double u) const
    {
        const bool lags = rig_.has_transfer_behaviour();
        const long double r = lags ? s[0] : u;
        const long double d_S = damping();
        const long double v = (s[3] + d_S * r) / rig_.object.mass_kg;
        const long double elastic = rig_.sensor.stiffness_N_per_m * (r - s[2]) - d_S * v; /* F without d_S r' */
        vector ds{};
        if (lags) {
            const long double w = 2.0L * M_PIl * rig_.robot.transfer_frequency_Hz;
            ds[0] = s[1];
            ds[1] = w * w * (u - s[0]) - 2.0L * rig_.robot.transfer_damping_ratio * w * s[1];
        }
        ds[2] = v;
        ds[3] = elastic - rig_.object.damping_N_s_per_m * v - rig_.object.stiffness_N_per_m * s[2];
        const long double w = low_pass_w();
        if (rig_.sensor.low_pass_order == 2) {
            const long double y_rate = s[5] + w * w * d_S * r;
            ds[4] = y_rate;
            ds[5] = w * w * (elastic - s[4]) - 2.0L * rig_.sensor.low_pass_damping_ratio * w * y_rate;
        } else if (rig_.sensor.low_pass_order == 1) {
            ds[4] = w * (elastic - s[4] - w * d_S * r);
        }
        return ds;
    }

    void step(long double slope, long double h)
    {
        vector term = state_;
        long double u = reference_m_;
        for (int n = 1; n <= 20; n++) {
            term = rate(term, u);
            for (std::size_t i = 0; i < term.size(); i++) {
                term[i] *= h / n;
                state_[i] += term[i];
            }
            u = n == 1 ? slope * h : 0.0L; /* Taylor coefficients of the reference */
        }
        reference_m_ += slope * h;
    }

    const rig &rig_;
    long double reference_m_;
    vector state_;
};

/* Setpoints of a random walk to the rig, one a tick, the same to the second opinion. */
comparison against_second_opinion(const rig &rig, std::int64_t seed)
{
    constexpr int ticks = 400;
    constexpr std::int64_t period_ns = 2500000;
    random_stream random(seed, 3);
    virtual_rig simulated(rig);
    second_opinion opinion(rig);
    const bool holds = rig.robot.interpolation == interpolation::hold;
    const std::int64_t delay_ticks = ns_from_ms(rig.robot.dead_time_ms) / period_ns;
    const std::int64_t phase_ns = ns_from_ms(rig.robot.dead_time_ms) % period_ns;
    std::vector<double> setpoints_m(static_cast<std::size_t>(delay_ticks) + 2,
                                    rig.firmware.manipulator.initial_position_m);
    comparison result;
    double slope = 0.0;
    for (std::int64_t tick = 0; tick < ticks; tick++) {
        simulated.advance_to(tick * period_ns);
        result.add(opinion.truth(slope), signals_of(simulated.truth()));

        const double wanted_m = setpoints_m.back() + 1e-4 * (random.uniform() - 0.5);
        berth_can_setpoint_t raw{};
        raw.position_m =
            berth_can_setpoint_position_m_encode(codec_round(wanted_m, berth_can_setpoint_position_m_decode(1)));
        raw.counter = static_cast<std::uint8_t>(tick);
        hal_frame frame{tick * period_ns, BERTH_CAN_SETPOINT_FRAME_ID, HAL_BUS_ROBOT, 8, 0, 0, {}};
        berth_can_setpoint_pack(frame.data, &raw, sizeof frame.data);
        simulated.receive_from_loop(frame);
        setpoints_m.push_back(berth_can_setpoint_position_m_decode(raw.position_m));

        /* Within the tick: the course up to the passage, then towards the next. The setpoint that is passed at
         * phase_ns is the one of delay_ticks ago. */
        const std::size_t passed = setpoints_m.size() - 1 - static_cast<std::size_t>(delay_ticks);
        const double next_slope = holds ? 0.0 : (setpoints_m[passed + 1] - setpoints_m[passed]) / (1e-9 * period_ns);
        opinion.advance(slope, phase_ns);
        opinion.jump_to(setpoints_m[passed]);
        slope = next_slope;
        opinion.advance(slope, period_ns - phase_ns);
    }
    return result;
}

} // namespace

TEST_CASE("the fast solver agrees with equations written a second time")
{
    REPRODUCIBLE();
    for (const char *interpolation : {"linear", "hold"}) {
        for (const char *order : {"0", "1", "2"}) {
            for (const char *transfer_Hz : {"inf", "8"}) {
                const std::string variant = std::string(interpolation) + ", order " + order + ", G_R " + transfer_Hz;
                CAPTURE(variant);
                const rig rig =
                    load_rig("ess", {"robot.dead_time_ms=16.2", std::string("robot.interpolation=") + interpolation,
                                     std::string("sensor.low_pass_order=") + order,
                                     std::string("robot.transfer_frequency_Hz=") + transfer_Hz});
                check_below(against_second_opinion(rig, test_seed()), 1e-10);
            }
        }
    }
}

/* Without a low-pass the sensor's damper shows the robot's velocity at once. With a dead time of one period the
 * robot does not know at a setpoint how to go on; that must not look like standing still. */
TEST_CASE("a robot with a dead time of one period does not seem to stop at each setpoint")
{
    REPRODUCIBLE();
    const rig rig = load_rig("ess", {"robot.dead_time_ms=2.5", "sensor.low_pass_order=0"});
    check_below(against_second_opinion(rig, test_seed()), 1e-10);
}

} // namespace berth
