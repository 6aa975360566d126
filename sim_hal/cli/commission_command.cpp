#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "../commission/commission.h"
#include "atomic_file.h"
#include "colour.h"
#include "commands.h"
#include "commission_page.h"
#include "compensation_choice.h"
#include "number.h"
#include "progress_line.h"
#include "robot_choice.h"

namespace berth
{

namespace
{

constexpr int exit_not_passed = 1;

void make_folder_for_stages(const std::string &folder)
{
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
        throw input_error(folder + ": the folder cannot be made (" + error.message() +
                          "); choose another with --out");
    }
}

/* "X,Y,Z" */
std::array<double, 3> direction_of(const std::string &text)
{
    std::array<double, 3> direction{};
    double length = 0.0;
    const char *at = text.c_str();
    bool is_read = true;
    for (std::size_t i = 0; i < direction.size(); i++) {
        const char *end = at;
        direction[i] = number_at<double>(at, &end);
        length += std::abs(direction[i]);
        is_read = is_read && end != at && *end == (i + 1 < direction.size() ? ',' : '\0');
        at = *end == ',' ? end + 1 : end;
    }
    if (!is_read || !(length > 0.0 && length < 1e6)) {
        throw input_error("--pose " + text +
                          ": must be X,Y,Z, where gravity points in the sensor's axes, as 0,0,-1");
    }
    return direction;
}

stage stage_of(const std::string &option, const std::string &name)
{
    const std::optional<stage> found = find_stage(name);
    if (!found) {
        throw input_error(option + " " + name + ": there are the stages watch, tare, step, shadow, ramp and run");
    }
    return *found;
}

/* Whose stages they are: those of a waiver, or of a question, are the record's. */
std::optional<commissioning_place> place_of(const commission_arguments &arguments)
{
    if (arguments.stage.empty()) {
        return {};
    }
    return arguments.logs.empty() ? commissioning_place::simulated : commissioning_place::target;
}

stage_entry waiver(const commission_arguments &arguments, const commissioning &record)
{
    if (arguments.because.empty()) {
        throw input_error("--waive " + arguments.waive + ": needs --because \"...\", which goes into the record");
    }
    return waiver_of(record, stage_of("--waive", arguments.waive), arguments.because);
}

/* The rig of the command line with further overrides. */
rig_loader loader_of(const commission_arguments &arguments, const std::optional<robot_preset> &robot)
{
    return [arguments, robot](const std::vector<std::string> &more) {
        std::vector<std::string> overrides = compensation_settings(arguments.with);
        overrides.insert(overrides.end(), arguments.overrides.begin(), arguments.overrides.end());
        overrides.insert(overrides.end(), more.begin(), more.end());
        return load_rig(arguments.rig, overrides, robot ? &*robot : nullptr);
    };
}

stage_request request_of(const commission_arguments &arguments, const rig_loader &loader, const std::string &folder)
{
    stage_request request;
    request.stage = stage_of("--stage", arguments.stage);
    request.load = loader;
    request.hardware = arguments.hardware;
    for (const std::string &pose : arguments.poses) {
        request.poses.push_back(direction_of(pose));
    }
    request.logs = arguments.logs;
    request.folder = folder;
    request.settings.ramp_s = arguments.ramp_s;
    request.margin = arguments.margin;
    return request;
}

void print_entry(const stage_entry &entry)
{
    const bool is_fine = entry.outcome == stage_outcome::passed;
    const std::string outcome(outcome_names[static_cast<std::size_t>(entry.outcome)]);
    std::printf("  %-7s %s: %s\n", name_of(entry.stage).c_str(),
                coloured(stdout, is_fine ? ink::green : ink::yellow, outcome).c_str(), entry.because.c_str());
    for (const stage_value &value : entry.values) {
        std::printf("          %s\n", words_of(value).c_str());
    }
}

void print_record(const commissioning &record, const std::string &configuration, const std::string &rig)
{
    for (std::size_t i = 0; i < stage_names.size(); i++) {
        const auto stage = static_cast<berth::stage>(i);
        const stage_entry *const entry = newest_entry(record, stage);
        const char *const state = entry == nullptr ? "not run"
                                  : is_done(record, stage, configuration)
                                      ? outcome_names[static_cast<std::size_t>(entry->outcome)].data()
                                      : "to be run";
        std::printf("  %-7s %-9s %s\n", name_of(stage).c_str(), state, std::string(stage_meanings[i]).c_str());
    }
    if (const std::optional<stage> next = next_stage(record, configuration)) {
        std::printf("next: berth commission %s --stage %s\n", rig.c_str(), name_of(*next).c_str());
    } else {
        std::printf("all stages are done\n");
    }
}

void write(const std::string &path, const std::string &text)
{
    atomic_file file(path);
    file.write(text);
    file.finish();
}

} // namespace

int commission_command(const commission_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    const rig &given = chosen.rig;
    const rig_loader loader = loader_of(arguments, chosen.robot);
    const std::string configuration = stage_configuration(given);
    const std::string folder =
        arguments.out_folder.empty() ? "build/commissioning/" + given.name : arguments.out_folder;
    const std::string path = arguments.record.empty() ? folder + "/record.json" : arguments.record;
    commissioning record = load_commissioning(path, given.name, place_of(arguments));

    std::optional<stage_entry> entry;
    if (!arguments.waive.empty()) {
        entry = waiver(arguments, record);
    } else if (!arguments.stage.empty()) {
        entry.emplace();
        entry->stage = stage_of("--stage", arguments.stage);
    }
    if (entry) {
        if (const std::string refusal = refusal_of(record, entry->stage, configuration); !refusal.empty()) {
            throw input_error(given.name + ": " + refusal);
        }
        if (arguments.waive.empty()) {
            stage_request request = request_of(arguments, loader, folder);
            const progress_line line;
            request.progress = [&](const std::string &what) { line.show(what); };
            make_folder_for_stages(folder);
            entry = commission_stage(request, record);
        }
        make_folder_for_stages(folder);
        entry->time = utc_now();
        entry->configuration = configuration;
        record.entries.push_back(*entry);
        save_commissioning(path, record);
        write(folder + "/proposal.toml", print_rig(loader(measured_overrides(record, stage::run))));
        write(folder + "/commissioning.html", commission_page(record, configuration));
    }
    if (arguments.json) {
        print_json(nlohmann::json::parse(print_commissioning(record)));
    } else {
        std::printf("%s: commissioning, %s rig\n", given.name.c_str(),
                    std::string(place_names[static_cast<std::size_t>(record.place)]).c_str());
        if (entry) {
            print_entry(*entry);
            std::printf("  record  %s\n  page    %s/commissioning.html\n", path.c_str(), folder.c_str());
        }
        print_record(record, configuration, arguments.rig);
    }
    return entry && entry->outcome == stage_outcome::failed ? exit_not_passed : 0;
}

} // namespace berth
