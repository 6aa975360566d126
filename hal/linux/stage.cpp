#include "stage.h"

#include <cstdio>
#include <filesystem>

#include "../rig/rig_file.h"

namespace berth
{

namespace
{

std::string record_path(const target_options &options, const std::string &log)
{
    return options.record_path.empty() ? (std::filesystem::path(log).parent_path() / "commissioning.json").string()
                                       : options.record_path;
}

std::string log_path(const target_options &options, const rig &given)
{
    const std::string &path = options.log_path.empty() ? given.target.log_path : options.log_path;
    if (path.empty()) {
        throw input_error("--stage " + options.stage +
                          ": needs a log, by which a PC judges the stage; name one behind the rig");
    }
    return path;
}

commissioning record_of(const target_options &options, const rig &given)
{
    return load_commissioning(record_path(options, log_path(options, given)), given.name,
                              commissioning_place::target);
}

} // namespace

rig target_rig_of(const target_options &options)
{
    rig given = load_rig(options.rig, options.overrides);
    if (options.stage.empty()) {
        return given;
    }
    stage_settings settings;
    settings.ramp_s = options.ramp_s;
    return begin_stage(record_of(options, given), options.rig, options.overrides, *find_stage(options.stage),
                       settings);
}

void note_stage(const target_options &options)
{
    if (options.stage.empty()) {
        return;
    }
    const rig given = load_rig(options.rig, options.overrides);
    const std::string log = log_path(options, given);
    commissioning record = record_of(options, given);
    stage_entry entry;
    entry.stage = *find_stage(options.stage);
    entry.outcome = stage_outcome::unjudged;
    entry.because = "it ran; its log is to be judged on a PC";
    entry.time = utc_now();
    entry.configuration = stage_configuration(given);
    entry.log = log;
    record.entries.push_back(entry);
    const std::string path = record_path(options, log);
    save_commissioning(path, record);
    std::fprintf(stderr, "stage %s has run; judge it on a PC: berth commission %s --stage %s --log %s --record %s\n",
                 options.stage.c_str(), options.rig.c_str(), options.stage.c_str(), log.c_str(), path.c_str());
}

} // namespace berth
