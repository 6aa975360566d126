/* Concept test of the paper: touch and push rubber foam and a copper sheet. The rigs differ in the material alone
 * and both materials are passive; through the dead time of the loop one is stable, the other is not. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "../support/closed_loop.h"

namespace berth
{

namespace
{

struct contact_run {
    int touches = 0;
    std::vector<double> deepest_m; /* of each touch */
    double peak_force_N = 0.0;
    double last_second_force_low_N = unlimited;
    double last_second_force_high_N = -unlimited;
    double work_lowest_J = 0.0; /* done on sensor, tool and material, up to any instant */
    double work_highest_J = 0.0;
    double end_position_m = 0.0;
    supervisor_state state = SUPERVISOR_START;
    stop_cause cause = STOP_NONE;
};

contact_run run(const std::string &name, const std::vector<std::string> &overrides = {})
{
    const rig rig = load_rig(name, overrides);
    closed_loop loop(rig);
    contact_run result;
    rig_truth before{};
    double work_J = 0.0;
    while (loop.tick()) {
        const rig_truth now = loop.truth();
        if (now.object_position_m > rig.object.surface_position_m) {
            if (before.object_position_m <= rig.object.surface_position_m && loop.app().recorder.tick.index > 0) {
                result.touches++;
                result.deepest_m.push_back(0.0);
            }
            result.deepest_m.back() = std::max(result.deepest_m.back(), now.object_position_m);
        }
        if (loop.app().recorder.tick.index > 0) {
            work_J += 0.5 * (now.spring_force_N + before.spring_force_N) *
                      (now.robot_position_m - before.robot_position_m);
        }
        result.work_lowest_J = std::min(result.work_lowest_J, work_J);
        result.work_highest_J = std::max(result.work_highest_J, work_J);
        result.peak_force_N = std::max(result.peak_force_N, now.measured_force_N);
        if (1e-9 * static_cast<double>(loop.app().recorder.tick.scheduled_ns) > rig.run.duration_s - 1.0) {
            result.last_second_force_low_N = std::min(result.last_second_force_low_N, now.measured_force_N);
            result.last_second_force_high_N = std::max(result.last_second_force_high_N, now.measured_force_N);
        }
        result.end_position_m = now.robot_position_m;
        before = now;
    }
    result.state = loop.app().supervisor.state;
    result.cause = loop.app().supervisor.stop_cause;
    return result;
}

/* Where operator spring and material balance, and the force there. */
double rest_position_m(const rig &rig)
{
    const double wanted_m = rig.profile.offset_m + rig.profile.amplitude_m;
    const double K = rig.firmware.manipulator.stiffness_N_per_m;
    return K * wanted_m / (K + rig.object.stiffness_N_per_m);
}

/* Copper with as little dead time as a loop can have: 0.25 ms in all at 10 kHz, no low-pass. */
const std::vector<std::string> no_dead_time = {"loop.rate_Hz=10000", "bus.ideal=true", "robot.dead_time_ms=0.1",
                                               "sensor.delay_ms=0.1", "sensor.low_pass_order=0"};

} // namespace

TEST_CASE("concept rigs differ in the material alone, and both materials are passive")
{
    rig foam = load_rig("concept-foam");
    const rig copper = load_rig("concept-copper");
    for (const rig &rig : {foam, copper}) {
        CHECK(rig.object.stiffness_N_per_m > 0.0);
        CHECK(rig.object.damping_N_s_per_m > 0.0);
    }
    foam.object = copper.object;
    foam.name = copper.name;
    foam.description = copper.description;
    CHECK(print_rig(foam) == print_rig(copper));

    /* Neither gives back more than it got, whatever the loop does to it. */
    for (const char *name : {"concept-foam", "concept-copper"}) {
        const contact_run result = run(name);
        CHECK(result.work_highest_J > 0.1);
        CHECK(result.work_lowest_J > -1e-3 * result.work_highest_J);
    }
}

TEST_CASE("concept test: foam is touched once and the loop comes to rest in contact")
{
    const rig rig = load_rig("concept-foam");
    const contact_run result = run("concept-foam");
    CHECK(result.touches == 1);
    CHECK(result.state == SUPERVISOR_RUNNING);
    const double x_m = rest_position_m(rig);
    const double force_N = rig.object.stiffness_N_per_m * x_m;
    CHECK(result.end_position_m == doctest::Approx(x_m).epsilon(0.002));
    CHECK(result.last_second_force_low_N == doctest::Approx(force_N).epsilon(0.002));
    CHECK(result.last_second_force_high_N == doctest::Approx(force_N).epsilon(0.002));
    CHECK(result.peak_force_N < 1.2 * force_N);
}

TEST_CASE("concept test: copper throws the tool back harder every time, until a limit ends it")
{
    const contact_run result = run("concept-copper");
    CHECK(result.touches >= 5);
    for (std::size_t i = 1; i + 1 < result.deepest_m.size(); i++) { /* the last may be cut by the fault */
        CHECK(result.deepest_m[i] > result.deepest_m[i - 1]);
    }
    CHECK(result.state == SUPERVISOR_FAULT);
    CHECK(result.cause == STOP_POSITION_LIMIT);
    CHECK(result.peak_force_N >
          20.0 * load_rig("concept-copper").object.stiffness_N_per_m * rest_position_m(load_rig("concept-copper")));
}

TEST_CASE("concept test: copper without dead time comes to rest in contact")
{
    std::vector<std::string> overrides = no_dead_time;
    overrides.push_back("run.duration_s=40");
    const contact_run result = run("concept-copper", overrides);
    const rig rig = load_rig("concept-copper");
    const double force_N = rig.object.stiffness_N_per_m * rest_position_m(rig);
    CHECK(result.state == SUPERVISOR_RUNNING);
    CHECK(result.touches <= 3);
    CHECK(result.last_second_force_low_N == doctest::Approx(force_N).epsilon(0.01));
    CHECK(result.last_second_force_high_N == doctest::Approx(force_N).epsilon(0.01));
}

TEST_CASE("claim 7: refining the simulation step does not keep copper from diverging")
{
    const char *const integrators[] = {"exact", "rk4", "semi_implicit_euler"};
    for (const std::string integrator : integrators) {
        for (const std::string substeps : {"1", "10", "1000"}) {
            CAPTURE(integrator);
            CAPTURE(substeps);
            const contact_run result =
                run("concept-copper", {"manipulator.integrator=" + integrator, "manipulator.substeps=" + substeps});
            CHECK(result.state == SUPERVISOR_FAULT);
            CHECK(result.touches >= 5);
        }
    }
}

/* The same without contact, where growth is one number: a gripped object as stiff as copper. */
TEST_CASE("claim 7: the growth rate of a diverging loop converges, to what the exact step has")
{
    const auto growth_per_s = [](const std::string &integrator, const std::string &substeps) {
        closed_loop loop("ess",
                         {"object.mass_kg=1", "object.stiffness_N_per_m=60000", "sensor.stiffness_N_per_m=2e6",
                          "object.damping_N_s_per_m=20", "manipulator.initial_position_m=1e-5", "run.duration_s=5",
                          "sensor_channel.force_limit_N=1e6", "manipulator.integrator=" + integrator,
                          "manipulator.substeps=" + substeps});
        const auto fit = fit_growth(free_motion_m(loop), 2.5e-3, 1e-8);
        REQUIRE(fit.has_value());
        return fit->growth_per_s;
    };
    const double exact = growth_per_s("exact", "1");
    CHECK(exact > 0.5);
    CHECK(growth_per_s("rk4", "1") == doctest::Approx(exact).epsilon(1e-6));
    CHECK(growth_per_s("rk4", "100") == doctest::Approx(exact).epsilon(1e-6));
    double last_error = unlimited;
    for (const char *substeps : {"1", "10", "100", "1000"}) { /* first order: ten times the steps, a tenth of it */
        const double error = std::abs(growth_per_s("semi_implicit_euler", substeps) - exact);
        CHECK(error < 0.2 * last_error);
        last_error = error;
    }
    CHECK(last_error < 1e-3 * exact);
}

} // namespace berth
