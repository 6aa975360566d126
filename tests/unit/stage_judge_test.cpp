/* How a stage is judged from its ticks, made up here: each way of failing, and what is proposed. */
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <string>

#include "hal/rig/rig_file.h"
#include "sim_hal/commission/judge.h"
#include "sim_hal/commission/step_stage.h"

namespace
{

constexpr std::uint32_t in_order = CONDITION_FEEDBACK_FRESH | CONDITION_SENSOR_FRESH | CONDITION_OPERATOR_FRESH;

/* Two seconds at 400 Hz in one state, one force sample a tick. */
berth::stage_run made_run(supervisor_state state)
{
    berth::stage_run run;
    run.load_step_s = 2.5e-3;
    for (int i = 0; i < 800; i++) {
        tick_record tick{};
        tick.index = i;
        tick.force_samples = static_cast<std::uint32_t>(i + 1);
        tick.conditions = in_order;
        tick.state = static_cast<std::uint8_t>(state);
        run.ticks.push_back(tick);
        run.loads.push_back({5.0});
    }
    run.motion.has_run = state == SUPERVISOR_RUNNING;
    return run;
}

struct watch_case {
    const char *what;
    const char *because; /* part of it; empty: it passes */
    std::function<void(berth::stage_run &)> spoil;
};

const watch_case watch_cases[] = {
    {"in order", "", [](berth::stage_run &) {}},
    {"a setpoint", "a setpoint was sent", [](berth::stage_run &run) { run.sent_setpoint = true; }},
    {"no operator", "operator",
     [](berth::stage_run &run) { run.ticks.back().conditions &= ~CONDITION_OPERATOR_FRESH; }},
    {"a bus off", "bus is off", [](berth::stage_run &run) { run.ticks.back().conditions |= CONDITION_BUS_OFF; }},
    {"nine losses in 800 ticks", "lost or rejected",
     [](berth::stage_run &run) { run.ticks.back().lost_frames = 9; }},
    {"seven losses", "", [](berth::stage_run &run) { run.ticks.back().lost_frames = 7; }},
    {"half the samples", "at the rate of the rig file",
     [](berth::stage_run &run) { run.ticks.back().force_samples /= 2; }},
    {"no tick", "made no tick", [](berth::stage_run &run) { run.ticks.clear(); }},
};

berth::diagnosis robot_diagnosis(berth::verdict verdict)
{
    berth::diagnosis found;
    berth::block_diagnosis robot{};
    robot.block = berth::block::robot;
    robot.verdict = verdict;
    if (verdict != berth::verdict::nothing_detectable) {
        berth::cause cause{};
        cause.effect = berth::find_effect("robot.dead_time");
        cause.parameters = {{"robot.dead_time_ms", 21.0, 0.1}};
        robot.causes.push_back(cause);
    }
    found.blocks.push_back(robot);
    found.extended = berth::load_rig("ess");
    return found;
}

} // namespace

TEST_CASE("stage judge: watch")
{
    const berth::rig ess = berth::load_rig("ess");
    for (const watch_case &one : watch_cases) {
        CAPTURE(one.what);
        berth::stage_run run = made_run(SUPERVISOR_START);
        one.spoil(run);
        const berth::stage_entry entry = berth::judge_watch(ess, run);
        CHECK((entry.outcome == berth::stage_outcome::passed) == std::string(one.because).empty());
        CHECK(entry.because.find(one.because) != std::string::npos);
    }
}

TEST_CASE("stage judge: tare compares with the file, and proposes")
{
    const berth::rig ess = berth::load_rig("ess", {"tare.force_x_N=4"});
    const berth::stage_entry entry = berth::judge_tare(ess, {{{0, 0, -9.8}, made_run(SUPERVISOR_START)}});
    CHECK(entry.outcome == berth::stage_outcome::passed);
    REQUIRE(entry.proposed.size() == 1);
    CHECK(entry.proposed[0].first == "tare.force_x_N");
    CHECK(entry.proposed[0].second == doctest::Approx(5.0));
    CHECK(entry.values[0].assumed == std::optional<double>(4.0));
}

TEST_CASE("stage judge: the diagnosis of the robot decides about the step")
{
    const berth::rig ess = berth::load_rig("ess");
    const struct {
        berth::verdict verdict;
        bool passes;
        std::size_t proposed;
    } cases[] = {{berth::verdict::nothing_detectable, true, 0},
                 {berth::verdict::named, true, 1},
                 {berth::verdict::one_of, true, 1},
                 {berth::verdict::partly_explained, false, 0},
                 {berth::verdict::unknown, false, 0},
                 {berth::verdict::software_mismatch, false, 0}};
    for (const auto &one : cases) {
        CAPTURE(static_cast<int>(one.verdict));
        const berth::stage_entry entry = berth::step_entry(robot_diagnosis(one.verdict), ess);
        CHECK((entry.outcome == berth::stage_outcome::passed) == one.passes);
        CHECK(entry.proposed.size() == one.proposed);
    }
    CHECK(berth::step_entry({}, ess).outcome == berth::stage_outcome::failed);
}

TEST_CASE("stage judge: shadow wants the margin, and proposes the feedback at which it is used up")
{
    const berth::rig ess = berth::load_rig("ess");
    const berth::stage_run run = made_run(SUPERVISOR_RUNNING);
    const berth::loop_promise damped{0.03, -0.3, "", {}};
    const berth::loop_promise growing{-0.01, 4.0, "", 0.6};
    const berth::loop_promise unknown{{}, {}, "it has no eigenvalues", {}};
    CHECK(berth::judge_shadow(ess, run, damped, damped, 0.01).outcome == berth::stage_outcome::passed);
    CHECK(berth::judge_shadow(ess, run, damped, damped, 0.04).outcome == berth::stage_outcome::failed);
    const berth::stage_entry entry = berth::judge_shadow(ess, run, growing, damped, 0.01);
    CHECK(entry.outcome == berth::stage_outcome::failed);
    REQUIRE(entry.proposed.size() == 1);
    CHECK(entry.proposed[0].first == "feedback.gain");
    CHECK(berth::judge_shadow(ess, run, unknown, unknown, 0.01).because.find("no eigenvalues") != std::string::npos);
    CHECK(berth::judge_shadow(ess, made_run(SUPERVISOR_READY), damped, damped, 0.01).because ==
          "the loop never ran");
}

TEST_CASE("stage judge: the force of the shadow moves the manipulator as its compliance says")
{
    /* A constant force on a spring from rest: it swings to 2 F/K at most, a little less with damping. */
    const berth::rig ess = berth::load_rig("ess", {"manipulator.initial_position_m=0"});
    berth::stage_run run = made_run(SUPERVISOR_RUNNING);
    for (tick_record &tick : run.ticks) {
        tick.force_N = 10.0;
    }
    const double static_m = 10.0 / ess.firmware.manipulator.stiffness_N_per_m;
    const double overshoot = std::exp(-M_PI * 0.05 / std::sqrt(1.0 - 0.0025));
    CHECK(berth::shadow_deviation_m(ess, run.ticks) == doctest::Approx(static_m * (1.0 + overshoot)).epsilon(1e-3));
}

TEST_CASE("stage judge: the ramp tells how far it came")
{
    const berth::rig ramp = berth::load_rig("ess", {"feedback.ramp_s=4"});
    berth::stage_run run = made_run(SUPERVISOR_RUNNING); /* half of it */
    run.motion.stop = {STOP_GROWTH, 2.0};
    const berth::stage_entry stopped = berth::judge_ramp(ramp, run, 0.01);
    CHECK(stopped.outcome == berth::stage_outcome::failed);
    CHECK(stopped.because == "the loop was stopped: growth, at a feedback of 0.500");
    CHECK(stopped.values[0].measured == doctest::Approx(0.5));
    run.motion.stop = {};
    CHECK(berth::judge_ramp(ramp, run, 0.01).outcome == berth::stage_outcome::failed);
    CHECK(berth::judge_ramp(berth::load_rig("ess", {"feedback.ramp_s=2"}), run, 0.01).outcome ==
          berth::stage_outcome::passed);
}
