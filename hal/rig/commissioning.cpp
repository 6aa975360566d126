#include "commissioning.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ctime>

#include "rig_file.h"

namespace berth
{

namespace
{

std::string assignment(std::string_view key, double value)
{
    char digits[40];
    const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
    return std::string(key).append("=").append(digits, end);
}

/* Place of the newest entry; -1: there is none. */
std::ptrdiff_t place_of(const commissioning &record, stage stage)
{
    const auto found = std::find_if(record.entries.rbegin(), record.entries.rend(),
                                    [&](const stage_entry &entry) { return entry.stage == stage; });
    return record.entries.rend() - found - 1;
}

/* What manipulator and object hold when they are let go: a stable loop gets no more back from its object. */
double growth_bound_J(const rig &given)
{
    const manipulator_config &c = given.firmware.manipulator;
    constexpr double least_stretch_m = 1e-3; /* of a loop that begins at rest: what an operator may do by hand */
    const double stretch_m =
        std::max(std::abs(c.initial_position_m - given.profile.offset_m) + std::abs(given.profile.amplitude_m),
                 least_stretch_m);
    const double speed_m_per_s = c.initial_velocity_m_per_s;
    return 0.5 * ((c.stiffness_N_per_m + given.object.stiffness_N_per_m) * stretch_m * stretch_m +
                  c.mass_kg * speed_m_per_s * speed_m_per_s);
}

/* The robot touches nothing, and there is no force to predict. */
const std::vector<std::string> without_object = {"object.kind=none", "prediction.enabled=false",
                                                 "identification.enabled=false", "force_lead.enabled=false"};

std::vector<std::string> joined(std::vector<std::string> first, const std::vector<std::string> &second)
{
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

} // namespace

std::string name_of(stage stage)
{
    return std::string(stage_names[static_cast<std::size_t>(stage)]);
}

std::optional<stage> find_stage(std::string_view name)
{
    const auto found = std::find(stage_names.begin(), stage_names.end(), name);
    return found == stage_names.end() ? std::optional<stage>() : static_cast<stage>(found - stage_names.begin());
}

const stage_entry *newest_entry(const commissioning &record, stage stage)
{
    const std::ptrdiff_t place = place_of(record, stage);
    return place < 0 ? nullptr : &record.entries[static_cast<std::size_t>(place)];
}

bool is_done(const commissioning &record, stage stage, std::string_view configuration)
{
    const stage_entry *const entry = newest_entry(record, stage);
    const bool is_in_order =
        stage == stage::watch ||
        place_of(record, stage) > place_of(record, static_cast<berth::stage>(static_cast<int>(stage) - 1));
    return entry != nullptr && is_in_order && entry->configuration == configuration &&
           (entry->outcome == stage_outcome::passed || entry->outcome == stage_outcome::waived);
}

std::optional<stage> next_stage(const commissioning &record, std::string_view configuration)
{
    for (std::size_t i = 0; i < stage_names.size(); i++) {
        if (!is_done(record, static_cast<stage>(i), configuration)) {
            return static_cast<stage>(i);
        }
    }
    return {};
}

std::string refusal_of(const commissioning &record, stage wanted, std::string_view configuration)
{
    const std::optional<stage> first = next_stage(record, configuration);
    if (!first || *first >= wanted) {
        return {};
    }
    const std::string name = name_of(*first);
    const stage_entry *const entry = newest_entry(record, *first);
    const char *why = "has not run yet";
    if (entry != nullptr) {
        why = entry->configuration != configuration       ? "was run with another rig file"
              : entry->outcome == stage_outcome::failed   ? "has failed"
              : entry->outcome == stage_outcome::unjudged ? "has run, and its log is not judged yet"
                                                          : "is older than the stage before it";
    }
    return "stage " + name_of(wanted) + " must wait: stage " + name + " " + why + "; run --stage " + name +
           ", or give --waive " + name + " --because \"...\"";
}

stage_entry waiver_of(const commissioning &record, stage stage, const std::string &because)
{
    const stage_entry *const before = newest_entry(record, stage);
    stage_entry entry = before != nullptr ? *before : stage_entry{};
    entry.stage = stage;
    entry.outcome = stage_outcome::waived;
    entry.because = because;
    return entry;
}

std::vector<std::string> measured_overrides(const commissioning &record, stage before)
{
    std::vector<std::string> overrides;
    for (std::size_t i = 0; i < static_cast<std::size_t>(before); i++) {
        const stage_entry *const entry = newest_entry(record, static_cast<stage>(i));
        if (entry == nullptr ||
            (entry->outcome != stage_outcome::passed && entry->outcome != stage_outcome::waived)) {
            continue;
        }
        for (const auto &[key, value] : entry->proposed) {
            overrides.push_back(assignment(key, value));
        }
    }
    return overrides;
}

std::string stage_configuration(const rig &given)
{
    rig lasting = given;
    lasting.run = {};
    lasting.profile = {};
    return config_hash(lasting);
}

std::vector<std::string> stage_overrides(stage stage, const rig &given, const stage_settings &settings)
{
    const double release_s = given.run.release_s;
    switch (stage) {
    case stage::watch:
        return {"robot_channel.watch_only=true", assignment("run.duration_s", 5.0)};
    case stage::tare:
        return joined({"robot_channel.watch_only=true", "tare.enabled=false", assignment("run.duration_s", 10.0)},
                      without_object);
    case stage::step:
        return joined({"feedback.gain=0", "profile.kind=multisine",
                       assignment("profile.amplitude_m", settings.amplitude_m), "profile.duration_s=20",
                       assignment("run.duration_s", release_s + 40.0)},
                      without_object);
    case stage::shadow:
        return {"feedback.gain=0", assignment("run.duration_s", release_s + 20.0)};
    case stage::ramp: {
        const double growth_J = std::min(given.firmware.reflex.growth_J, growth_bound_J(given));
        const double gain = std::min(settings.gain_max, given.firmware.feedback.gain);
        return {assignment("feedback.gain", gain), assignment("feedback.ramp_s", settings.ramp_s),
                assignment("reflex.growth_J", growth_J),
                assignment("run.duration_s", release_s + settings.ramp_s + 5.0)};
    }
    case stage::run:
        break;
    }
    return {};
}

rig begin_stage(const commissioning &record, const std::string &name, const std::vector<std::string> &overrides,
                stage stage, const stage_settings &settings)
{
    const rig given = load_rig(name, overrides);
    if (const std::string refusal = refusal_of(record, stage, stage_configuration(given)); !refusal.empty()) {
        throw input_error(given.name + ": " + refusal);
    }
    std::vector<std::string> all = overrides;
    const auto add = [&](const std::vector<std::string> &more) { all.insert(all.end(), more.begin(), more.end()); };
    add(measured_overrides(record, stage));
    add(stage_overrides(stage, load_rig(name, all), settings));
    return load_rig(name, all);
}

std::string utc_now()
{
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    gmtime_r(&now, &parts);
    char text[40];
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
    return text;
}

} // namespace berth
