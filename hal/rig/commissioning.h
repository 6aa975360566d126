/* The order in which a laboratory closes its first loop, and the record of how far it has come. A stage begins only
 * when every stage before it was passed, or waived by its name, with the same rig. */
#ifndef HAL_RIG_COMMISSIONING_H
#define HAL_RIG_COMMISSIONING_H

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "rig.h"

namespace berth
{

enum class stage {
    watch,  /* no setpoint is sent */
    tare,   /* the sensor at standstill: zero, noise, drift, tool */
    step,   /* small setpoints, the force not fed back: the robot alone */
    shadow, /* the same with the object: what the loop would command */
    ramp,   /* feedback from 0 to 1 */
    run     /* the whole loop */
};

constexpr std::array<std::string_view, 6> stage_names = {"watch", "tare", "step", "shadow", "ramp", "run"};
constexpr std::array<std::string_view, 6> stage_meanings = {
    "no setpoint is sent: buses, sensor and lines",
    "the sensor at standstill: zero, noise, drift, weight of the tool",
    "small setpoints, no feedback, no object: dead time and behaviour of the robot",
    "no feedback, with the object: what the loop would command, predicted damping",
    "feedback from 0 to 1, growth reflex armed",
    "the whole loop"};

std::string name_of(stage stage);
std::optional<stage> find_stage(std::string_view name);

enum class stage_outcome {
    passed,
    failed,
    waived,
    unjudged /* it ran on a target; a PC judges its log */
};

constexpr std::array<std::string_view, 4> outcome_names = {"passed", "failed", "waived", "unjudged"};

/* One number that a stage measured. */
struct stage_value {
    std::string name;
    std::string unit;
    double measured = 0.0;
    std::optional<double> assumed;     /* by the rig file; nothing: it says nothing of it */
    std::optional<double> uncertainty; /* half width of the 95 % interval */
};

struct stage_entry {
    berth::stage stage = stage::watch;
    stage_outcome outcome = stage_outcome::failed;
    std::string because; /* one sentence; of a waiver: the reason that a person gave */
    std::string time;
    std::string configuration; /* see stage_configuration() */
    std::string log;           /* empty: none */
    std::vector<stage_value> values;
    std::vector<std::pair<std::string, double>> proposed; /* keys of the rig file, used by the stages after it */
};

/* Where the stages ran: those on a simulated rig say nothing about a real one. */
enum class commissioning_place { simulated, target };

constexpr std::array<std::string_view, 2> place_names = {"simulated", "target"};

struct commissioning {
    std::string rig;
    commissioning_place place = commissioning_place::simulated;
    std::vector<stage_entry> entries; /* in the order in which they were made */
};

/* The newest entry of the stage, or nullptr. */
const stage_entry *newest_entry(const commissioning &record, stage stage);

/* Passed or waived, with this configuration, and after the newest entry of the stage before it. */
bool is_done(const commissioning &record, stage stage, std::string_view configuration);

/* Why the stage must not begin: one sentence with what to do. Empty: it may. */
std::string refusal_of(const commissioning &record, stage wanted, std::string_view configuration);

/* The first stage that is not done; nothing: all are. */
std::optional<stage> next_stage(const commissioning &record, std::string_view configuration);

/* Goes on without the stage, for a reason that a person gives. What it has measured so far stays. */
stage_entry waiver_of(const commissioning &record, stage stage, const std::string &because);

/* "section.key=value": what the stages before this one have measured, for load_rig(). */
std::vector<std::string> measured_overrides(const commissioning &record, stage before);

/* Names the rig, without what may change from run to run: [run], [profile]. */
std::string stage_configuration(const rig &given);

struct stage_settings {
    double ramp_s = 60.0;       /* in which the feedback would rise from 0 to 1 */
    double gain_max = 1.0;      /* at which the ramp ends */
    double amplitude_m = 0.005; /* of the setpoints in the stage step */
};

/* "section.key=value": what the stage changes of the rig. */
std::vector<std::string> stage_overrides(stage stage, const rig &given, const stage_settings &settings);

/* The record as JSON, and back. Throws input_error. */
std::string print_commissioning(const commissioning &record);
commissioning parse_commissioning(const std::string &text, const std::string &origin);

/* Of a file; a record without entries where there is no file. Throws input_error where it is of another rig or
 * place; without `place`, any will do. */
commissioning load_commissioning(const std::string &path, const std::string &rig,
                                 std::optional<commissioning_place> place);
/* The rig of a stage that begins now: with what was measured, and what the stage changes. `overrides`: of the
 * command line. Throws input_error where the stage must wait. */
rig begin_stage(const commissioning &record, const std::string &rig, const std::vector<std::string> &overrides,
                stage stage, const stage_settings &settings);

/* The current time in UTC, as records have it. */
std::string utc_now();

void save_commissioning(const std::string &path, const commissioning &record);

} // namespace berth

#endif
