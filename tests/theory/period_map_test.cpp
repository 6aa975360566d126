/* The matrix of eigenvalues and maps against what runs: its every element is the derivative of one real tick,
 * firmware step and simulated rig, frames and their rounding included. */
#include <cmath>
#include <doctest/doctest.h>
#include <Eigen/Core>

#include "../../sim_hal/hil/random.h"
#include "../../sim_hal/solver/decompositions.h"
#include "../../sim_hal/stability/period_map.h"
#include "../support/closed_loop.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

/* Differences as large as the frames allow: their steps (10 pm, 0.1 uN) are 1e-8 of them. */
constexpr double difference_m = 1e-3;
constexpr double difference_m_per_s = 0.1;

/* Least squares over this many times as many ticks as there are states. */
constexpr Eigen::Index ticks_per_state = 6;

/* At each tick everything that has a memory is put into a random state: manipulator, filter and plant directly,
 * setpoints and samples on their way by what was sent and sampled before. Then one tick runs as always. */
class shaken_loop
{
  public:
    explicit shaken_loop(const rig &rig)
        : loop_(rig), hardware_(rig), layout_(period_map(rig).layout()), period_ns_(config_period_ns(&rig.firmware)),
          scales_(plant(rig).natural_scales<beam_state>() * difference_m), random_(test_seed(), 2)
    {
    }

    /* Sizes of the differences, by state. */
    Eigen::VectorXd sizes() const
    {
        Eigen::VectorXd sizes = Eigen::VectorXd::Constant(layout_.count, difference_m);
        sizes(layout_.manipulator + 1) = difference_m_per_s;
        for (int i = 0; i < hardware_.state_count(); i++) {
            sizes(layout_.plant + i) = scales_(hardware_.state(i));
        }
        sizes.tail(layout_.count - layout_.samples).setConstant(scales_(filter_output));
        return sizes;
    }

    /* The derivative of a tick. */
    Eigen::MatrixXd jacobian()
    {
        while (!loop_.is_running()) {
            REQUIRE(loop_.tick());
        }
        const Eigen::Index columns = ticks_per_state * layout_.count;
        const Eigen::Index first = layout_.count + 1; /* by then all setpoints and samples are of random states */
        const Eigen::Index last = first + columns;
        const std::int64_t start = loop_.app().recorder.tick.index + 1;
        std::vector<Eigen::VectorXd> put;
        std::vector<Eigen::VectorXd> reached;
        std::vector<double> setpoints_m;
        std::vector<double> forces_N;
        for (Eigen::Index k = 0; k <= last + layout_.count; k++) {
            sim_rig(loop_.hal()).approach((start + k) * period_ns_);
            reached.push_back(look());
            put_random_state();
            put.push_back(look());
            REQUIRE(loop_.tick());
            REQUIRE(loop_.is_running());
            REQUIRE(loop_.app().limits.active == 0);
            setpoints_m.push_back(loop_.app().recorder.tick.command_position_m);
            forces_N.push_back(loop_.app().recorder.tick.force_N);
        }
        const auto complete = [&](Eigen::VectorXd state, Eigen::Index tick) {
            for (Eigen::Index i = layout_.setpoints; i < layout_.samples; i++) {
                state(i) = setpoints_m[static_cast<std::size_t>(tick - 1 - (i - layout_.setpoints))];
            }
            for (Eigen::Index i = layout_.samples; i < layout_.count; i++) { /* seen when they arrive */
                state(i) = forces_N[static_cast<std::size_t>(tick + layout_.count - 1 - i)];
            }
            return state.cwiseQuotient(sizes()).eval();
        };
        Eigen::MatrixXd before(layout_.count, columns);
        Eigen::MatrixXd after(layout_.count, columns);
        for (Eigen::Index i = 0; i < columns; i++) {
            const Eigen::Index tick = first + i;
            before.col(i) = complete(put[static_cast<std::size_t>(tick)], tick);
            after.col(i) = complete(reached[static_cast<std::size_t>(tick + 1)], tick + 1);
        }
        /* after = J before */
        return least_squares_solution(before.transpose(), after.transpose()).transpose();
    }

  private:
    void put_random_state()
    {
        const Eigen::VectorXd size = sizes();
        const auto draw = [&](Eigen::Index i) { return size(i) * (2.0 * random_.uniform() - 1.0); };
        struct app &app = loop_.app();
        app.manipulator.position_m = draw(layout_.manipulator);
        app.manipulator.velocity_m_per_s = draw(layout_.manipulator + 1);
        if (app.inverse_filter.enabled) {
            for (int i = 0; i < 2; i++) {
                app.inverse_filter.input_m[i] = draw(layout_.filter + i);
                app.inverse_filter.output_m[i] = draw(layout_.filter + 2 + i);
            }
        }
        beam_state state = beam_state::Zero();
        for (int i = 0; i < hardware_.state_count(); i++) {
            state(hardware_.state(i)) = draw(layout_.plant + i);
        }
        sim_rig(loop_.hal()).set_state(state);
    }

    /* All but setpoints and samples on their way. */
    Eigen::VectorXd look() const
    {
        Eigen::VectorXd state = Eigen::VectorXd::Zero(layout_.count);
        const struct app &app = loop_.app();
        state.segment<2>(layout_.manipulator) << app.manipulator.position_m, app.manipulator.velocity_m_per_s;
        if (app.inverse_filter.enabled) {
            state.segment<4>(layout_.filter) << app.inverse_filter.input_m[0], app.inverse_filter.input_m[1],
                app.inverse_filter.output_m[0], app.inverse_filter.output_m[1];
        }
        for (int i = 0; i < hardware_.state_count(); i++) {
            state(layout_.plant + i) = sim_rig(loop_.hal()).state()(hardware_.state(i));
        }
        return state;
    }

    mutable closed_loop loop_;
    hardware_period hardware_;
    period_layout layout_;
    std::int64_t period_ns_;
    beam_state scales_;
    random_stream random_;
};

rig resting_rig(const std::vector<std::string> &overrides, const std::string &name = "ess")
{
    std::vector<std::string> all{"manipulator.initial_position_m=0",
                                 "run.release_s=0",
                                 "run.duration_s=1000",
                                 "sensor_channel.force_limit_N=54000",
                                 "limits.velocity_m_per_s=1e6",
                                 "limits.acceleration_m_per_s2=1e9",
                                 "limits.position_min_m=-5",
                                 "limits.position_max_m=5",
                                 "sensor.stiffness_N_per_m=2e6"};
    all.insert(all.end(), overrides.begin(), overrides.end());
    return load_rig(name, all);
}

/* Largest error of an element, in units of the differences, as a share of the largest element in its row. */
double jacobian_error(const rig &modelled, const rig &running)
{
    shaken_loop loop(running);
    const Eigen::VectorXd sizes = loop.sizes();
    const Eigen::MatrixXd matrix =
        sizes.cwiseInverse().asDiagonal() * period_map(modelled).matrix() * sizes.asDiagonal();
    const Eigen::MatrixXd error = (loop.jacobian() - matrix).cwiseAbs();
    return error.rowwise().maxCoeff().cwiseQuotient(matrix.cwiseAbs().rowwise().maxCoeff()).maxCoeff();
}

struct map_case {
    std::string name;
    std::vector<std::string> overrides;
};

const std::vector<map_case> &map_cases()
{
    static const std::string linear = "robot.interpolation=linear";
    static const std::string hold = "robot.interpolation=hold";
    static const std::string second_mass = "object.second_mass_kg=15";
    static const std::vector<map_case> all{
        {"ess", {}},
        {"50 Hz", {"loop.rate_Hz=50", "robot.dead_time_ms=40", "sensor.delay_ms=20"}},
        {"dead times of no whole ticks", {"robot.dead_time_ms=13.3", "sensor.delay_ms=4.1"}},
        {"hold", {hold}},
        {"hold, no whole ticks", {hold, "robot.dead_time_ms=13.3", "sensor.delay_ms=4.1"}},
        {"hold, less than a tick", {hold, "robot.dead_time_ms=0.9", "sensor.delay_ms=0.3"}},
        {"robot with transfer behaviour", {"robot.transfer_frequency_Hz=12", "robot.dead_time_ms=6.1"}},
        {"transfer behaviour, hold", {hold, "robot.transfer_frequency_Hz=12", "robot.dead_time_ms=6.1"}},
        {"inverse filter",
         {"robot.transfer_frequency_Hz=12", "inverse_filter.enabled=true", "inverse_filter.bandwidth_Hz=40"}},
        {"tool behind the sensor", {"sensor.tool_mass_kg=20", "robot.dead_time_ms=8.8"}},
        {"tool behind the sensor, hold", {hold, "sensor.tool_mass_kg=20", "robot.dead_time_ms=8.8"}},
        {"tool behind the sensor of a robot with transfer behaviour and lag",
         {"sensor.tool_mass_kg=20", "robot.transfer_frequency_Hz=12", "robot.lag_ms=4", "robot.dead_time_ms=6.1"}},
        {"object that relaxes",
         {"object.relaxation_stiffness_N_per_m=900", "object.relaxation_time_ms=60", "robot.dead_time_ms=8.8"}},
        {"object that relaxes, with a second mass",
         {second_mass, "object.second_frequency_Hz=3", "object.second_damping_ratio=0.02",
          "object.relaxation_stiffness_N_per_m=900", "object.relaxation_time_ms=60"}},
        {"low-pass of order 1", {"sensor.low_pass_order=1", "robot.dead_time_ms=8.8"}},
        {"no low-pass", {"sensor.low_pass_order=0", "robot.dead_time_ms=8.8"}},
        {"no low-pass, hold", {hold, "sensor.low_pass_order=0", "robot.dead_time_ms=8.8"}},
        {"sample between ticks", {"sensor.sample_phase_ms=1.2", "robot.dead_time_ms=8.8"}},
        {"sample and setpoint at once",
         {"sensor.sample_phase_ms=1.3", "robot.dead_time_ms=8.8", "sensor.delay_ms=3"}},
        {"two samples a tick", {"sensor.rate_Hz=800", "sensor.delay_ms=2.0", "robot.dead_time_ms=8.8"}},
        {"four samples a tick, between ticks",
         {"sensor.rate_Hz=1600", "sensor.sample_phase_ms=0.4", "sensor.delay_ms=3.1", "robot.dead_time_ms=8.8"}},
        {"sample at the tick, one tick of dead time", {"robot.dead_time_ms=2.5"}},
        {"coarse integrator", {"manipulator.integrator=semi_implicit_euler", "manipulator.substeps=2"}},
        {"gain of the sensor", {"sensor.gain_error=-0.2"}}, /* the robot's is in other units, eigenvalues the same */
        {"lag of the robot", {"robot.lag_ms=7", "robot.dead_time_ms=8.8"}},
        {"lag of the robot, hold", {hold, "robot.lag_ms=7", "robot.dead_time_ms=8.8"}},
        {"lag behind transfer behaviour", {"robot.lag_ms=30", "robot.transfer_frequency_Hz=12"}},
        {"lag of the sensor", {"sensor.lag_ms=5"}},
        {"lag of the sensor behind order 1", {"sensor.lag_ms=20", "sensor.low_pass_order=1"}},
        {"lag of the sensor instead of a low-pass, hold", {hold, "sensor.lag_ms=2", "sensor.low_pass_order=0"}},
        {"second mode", {second_mass, "object.second_frequency_Hz=5", "object.second_damping_ratio=0.02"}},
        {"second mode, overdamped",
         {second_mass, "object.second_frequency_Hz=40", "object.second_damping_ratio=1.7"}},
        {"all that is linear",
         {hold, second_mass, "object.second_frequency_Hz=8", "object.second_damping_ratio=0.05", "sensor.lag_ms=3",
          "robot.lag_ms=4", "robot.transfer_frequency_Hz=12", "inverse_filter.enabled=true"}},
    };
    return all;
}

} // namespace

TEST_CASE("the period map is the derivative of one real tick to 1e-6")
{
    REPRODUCIBLE();
    for (const map_case &of : map_cases()) {
        CAPTURE(of.name);
        const rig rig = resting_rig(of.overrides);
        const double error = jacobian_error(rig, rig);
        MESSAGE(of.name << ": largest relative difference " << error);
        CHECK(error < 1e-6);
    }
}

TEST_CASE("the period map of a beam is the derivative of one real tick to 1e-6")
{
    REPRODUCIBLE();
    const std::vector<std::vector<std::string>> variants{
        {"object.modes=2"},
        {"object.modes=3", "robot.interpolation=hold"},
        {"object.modes=4", "robot.lag_ms=4", "robot.transfer_frequency_Hz=12", "sensor.lag_ms=3"},
        {"object.modes=8", "object.beam_root_stiffness_N_m_per_rad=2e5", "robot.dead_time_ms=13.3"},
    };
    for (const std::vector<std::string> &overrides : variants) {
        CAPTURE(overrides.front());
        const rig rig = resting_rig(overrides, "ess-beam");
        const double error = jacobian_error(rig, rig);
        MESSAGE(overrides.front() << ": largest relative difference " << error);
        CHECK(error < 1e-6);
    }
}

TEST_CASE("the comparison of map and tick notices 10 us of dead time, or 1e-5 of a mass")
{
    const rig rig = resting_rig({"robot.dead_time_ms=13.3"});
    CHECK(jacobian_error(rig, resting_rig({"robot.dead_time_ms=13.31"})) > 1e-3);
    CHECK(jacobian_error(rig, resting_rig({"robot.dead_time_ms=13.3", "object.mass_kg=100.001"})) > 1e-6);
}

} // namespace berth
