/* The order of the stages and their record, and what the firmware does in them. */
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "firmware/force_feedback.h"
#include "hal/rig/commissioning.h"
#include "hal/rig/rig_file.h"
#include "hal/rig/tool_load.h"
#include "tick_builder.h"

namespace
{

using berth::stage;
using berth::stage_outcome;

constexpr const char *same_rig = "a";

berth::stage_entry entry_of(stage stage, stage_outcome outcome, const char *configuration = same_rig)
{
    berth::stage_entry entry;
    entry.stage = stage;
    entry.outcome = outcome;
    entry.configuration = configuration;
    return entry;
}

berth::commissioning record_of(const std::vector<berth::stage_entry> &entries)
{
    return {"ess", berth::commissioning_place::simulated, entries};
}

struct order_case {
    const char *what;
    std::vector<berth::stage_entry> entries;
    stage wanted;
    const char *refusal; /* part of it; empty: it may begin */
};

const stage_outcome passed = stage_outcome::passed;

std::vector<order_case> order_cases()
{
    const auto watch = entry_of(stage::watch, passed);
    const auto tare = entry_of(stage::tare, passed);
    return {
        {"the first stage", {}, stage::watch, ""},
        {"nothing has run", {}, stage::tare, "stage watch has not run yet"},
        {"the one before was passed", {watch}, stage::tare, ""},
        {"two before", {watch}, stage::step, "stage tare has not run yet"},
        {"the last of all", {watch, tare}, stage::run, "stage step has not run yet"},
        {"failed", {watch, entry_of(stage::tare, stage_outcome::failed)}, stage::step, "stage tare has failed"},
        {"waived", {watch, entry_of(stage::tare, stage_outcome::waived)}, stage::step, ""},
        {"not judged", {watch, entry_of(stage::tare, stage_outcome::unjudged)}, stage::step, "is not judged yet"},
        {"passed after it failed", {watch, entry_of(stage::tare, stage_outcome::failed), tare}, stage::step, ""},
        {"failed after it was passed",
         {watch, tare, entry_of(stage::tare, stage_outcome::failed)},
         stage::step,
         "stage tare has failed"},
        {"another rig file", {watch, entry_of(stage::tare, passed, "b")}, stage::step, "with another rig file"},
        {"an early stage anew", {watch, tare, watch}, stage::step, "stage tare is older than the stage before it"},
        {"an early stage again", {watch, tare}, stage::watch, ""},
    };
}

} // namespace

TEST_CASE("commissioning: a stage waits for all before it")
{
    for (const order_case &one : order_cases()) {
        CAPTURE(one.what);
        const std::string refusal = berth::refusal_of(record_of(one.entries), one.wanted, same_rig);
        CHECK(refusal.empty() == std::string(one.refusal).empty());
        CHECK(refusal.find(one.refusal) != std::string::npos);
    }
}

TEST_CASE("commissioning: the record reads back as it was written")
{
    berth::stage_entry entry = entry_of(stage::tare, passed);
    entry.because = "\"why\" & so";
    entry.time = "2026-11-30T12:00:00Z";
    entry.log = "tare.ulg";
    entry.values = {{"zero", "N", 3.25, 0.0, 0.01}, {"drift", "N/min", 0.1, {}, {}}};
    entry.proposed = {{"tare.force_x_N", 3.25}};
    const std::string text = berth::print_commissioning(record_of({entry}));
    const berth::commissioning record = berth::parse_commissioning(text, "it");
    CHECK(berth::print_commissioning(record) == text);
    REQUIRE(record.entries.size() == 1);
    CHECK(record.entries[0].values[0].uncertainty == std::optional<double>(0.01));
    CHECK(!record.entries[0].values[1].assumed);
    CHECK(record.entries[0].proposed[0].second == 3.25);
    CHECK_THROWS_AS(berth::parse_commissioning("{}", "it"), berth::input_error);
    CHECK_THROWS_AS(berth::parse_commissioning("not json", "it"), berth::input_error);
}

TEST_CASE("commissioning: later stages use what passed stages before them have measured")
{
    auto tare = entry_of(stage::tare, passed);
    tare.proposed = {{"tare.force_x_N", 3.25}};
    auto step = entry_of(stage::step, stage_outcome::failed);
    step.proposed = {{"robot.dead_time_ms", 99.0}};
    const auto record = record_of({entry_of(stage::watch, passed), tare, step});
    CHECK(berth::measured_overrides(record, stage::tare).empty());
    CHECK(berth::measured_overrides(record, stage::run) == std::vector<std::string>{"tare.force_x_N=3.25"});
}

TEST_CASE("commissioning: run and profile may change between stages, the rig may not")
{
    const auto hash = [](const std::vector<std::string> &overrides) {
        return berth::stage_configuration(berth::load_rig("ess", overrides));
    };
    CHECK(hash({"run.duration_s=3", "profile.amplitude_m=0.1"}) == hash({}));
    CHECK(hash({"object.mass_kg=101"}) != hash({}));
}

TEST_CASE("commissioning: every stage makes a rig that can be loaded")
{
    const berth::rig ess = berth::load_rig("ess");
    for (std::size_t i = 0; i < berth::stage_names.size(); i++) {
        CAPTURE(berth::stage_names[i]);
        const auto stage = static_cast<berth::stage>(i);
        const berth::rig changed = berth::load_rig("ess", berth::stage_overrides(stage, ess, {}));
        CHECK(changed.firmware.robot_channel.watch_only == (stage <= stage::tare));
        CHECK(changed.firmware.feedback.gain == (stage == stage::step || stage == stage::shadow ? 0.0 : 1.0));
        CHECK((changed.firmware.feedback.ramp_s > 0.0) == (stage == stage::ramp));
        CHECK(std::isfinite(changed.firmware.reflex.growth_J) == (stage == stage::ramp));
    }
}

TEST_CASE("commissioning: the feedback rises by the same step each tick, and begins anew with each run")
{
    app_config config = config_default();
    config.feedback = {0.6, 2.0}; /* of 800 ticks from 0 to 1 */
    CHECK(force_feedback_gain(&config, 0) == 0.0);
    CHECK(force_feedback_gain(&config, 1) == doctest::Approx(1.0 / 800));
    CHECK(force_feedback_gain(&config, 400) == doctest::Approx(0.5));
    CHECK(force_feedback_gain(&config, 480) == doctest::Approx(0.6));
    CHECK(force_feedback_gain(&config, 100000) == 0.6);
    force_feedback feedback;
    force_feedback_start(&feedback, &config);
    CHECK(!feedback.is_whole);
    for (int tick = 1; tick <= 1000; tick++) {
        force_feedback_step(&feedback, 1);
        REQUIRE(feedback.gain == force_feedback_gain(&config, tick));
    }
    force_feedback_step(&feedback, 0);
    CHECK(feedback.gain == 0.0);
    force_feedback_step(&feedback, 1);
    CHECK(feedback.gain == doctest::Approx(1.0 / 800));
    config.feedback = {0.3, 0.0};
    CHECK(force_feedback_gain(&config, 1) == 0.3);
}

TEST_CASE("commissioning: a share of the measured force reaches the manipulator")
{
    for (const double gain : {0.0, 0.25, 1.0}) {
        CAPTURE(gain);
        app_config config = bench::moving_config();
        config.feedback.gain = gain;
        bench::app_bench bench(config);
        bench.request = OPERATOR_RUN;
        bench.force_N = 40.0;
        REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
        bench.tick();
        CHECK(bench.app().recorder.tick.force_N == doctest::Approx(40.0));
        CHECK(bench.app().recorder.tick.used_force_N == doctest::Approx(40.0 * gain));
    }
}

TEST_CASE("commissioning: a loop that only watches never sends a setpoint")
{
    app_config config = bench::moving_config();
    config.robot_channel.watch_only = 1;
    bench::app_bench bench(config);
    bench.request = OPERATOR_RUN;
    bench.waits_until_ready = false;
    for (int i = 0; i < 1000; i++) {
        bench.tick();
        REQUIRE(bench.state() == SUPERVISOR_START);
        for (std::uint32_t k = 0; k < bench.out().frame_count; k++) {
            REQUIRE(bench.out().frames[k].id != BERTH_CAN_SETPOINT_FRAME_ID);
        }
    }
    CHECK((bench.app().recorder.tick.conditions & CONDITION_FEEDBACK_FRESH) != 0);
    bench.emergency_stop = 1; /* a loop in fault holds the robot; this one must not */
    for (int i = 0; i < 100; i++) {
        bench.tick();
        REQUIRE(bench.state() == SUPERVISOR_FAULT);
        REQUIRE(bench.out().frame_count == 0);
    }
    config.robot_channel.profile = ROBOT_PROFILE_CIA402;
    CHECK(std::string(config_validate(&config).key) == "robot_channel.watch_only");
}

TEST_CASE("commissioning: zero and weight are taken off the force, and the limit is that of the sensor")
{
    app_config config = bench::moving_config();
    config.tare = {1, {100.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    config.sensor_channel.force_limit_N = 150.0;
    bench::app_bench bench(config);
    bench.force_N = 130.0;
    bench.tick();
    CHECK(bench.app().sensor_channel.force_N == doctest::Approx(30.0));
    CHECK(!bench.app().sensor_channel.over_limit);
    bench.force_N = 160.0; /* 60 N without the tare */
    bench.tick();
    CHECK(bench.app().sensor_channel.over_limit);
}

TEST_CASE("commissioning: a tool hangs on its sensor")
{
    /* 2 kg, 0.1 m in front of a sensor whose x axis is level and whose z axis points up. */
    berth::tool_rig tool;
    tool.mass_kg = 2.0;
    tool.centre_m = {0.1, 0.0, 0.0};
    tool.gravity_m_per_s2 = {0.0, 0.0, -10.0};
    const auto load = berth::tool_load(tool);
    const std::vector<double> expected = {0.0, 0.0, 20.0, 0.0, -2.0, 0.0};
    for (std::size_t i = 0; i < 6; i++) {
        CHECK(load[i] == doctest::Approx(expected[i]));
    }
    berth::rig rig = berth::load_rig("ess", {"tool.mass_kg=2", "tare.force_x_N=3"});
    CHECK(rig.firmware.tare.enabled);
    CHECK(rig.firmware.tare.force_N[0] == 3.0);
    CHECK(rig.firmware.tare.force_N[2] == doctest::Approx(19.6133));
    CHECK(!berth::load_rig("ess", {"tool.mass_kg=2", "tare.enabled=false"}).firmware.tare.enabled);
    CHECK(!berth::load_rig("ess").firmware.tare.enabled);
}
