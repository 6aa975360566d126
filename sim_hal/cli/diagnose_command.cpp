#include <charconv>
#include <cmath>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "../../hal/rig/beam.h"
#include "../../hal/rig/given.h"
#include "../../hal/rig/names.h"
#include "../../hal/rig/units.h"
#include "../../hal/version.h"
#include "../diagnosis/diagnosis.h"
#include "../stability/arm_loop.h"
#include "atomic_file.h"
#include "commands.h"
#include "diagnosis_report.h"
#include "progress_line.h"

namespace berth
{

namespace
{

std::string_view name_of(block block)
{
    return block_names[static_cast<int>(block)];
}

std::string_view name_of(verdict verdict)
{
    return verdict_names[static_cast<int>(verdict)];
}

const char *channel_of(block block)
{
    return block == block::manipulator ? "command_position_m"
           : block == block::robot     ? "robot_position_m"
                                       : "force_N";
}

nlohmann::json as_json(const std::vector<parameter_estimate> &parameters)
{
    nlohmann::json all = nlohmann::json::array();
    for (const parameter_estimate &parameter : parameters) {
        const interval known = interval_of(parameter);
        all.push_back({{"key", parameter.key},
                       {"value", parameter.value},
                       {"fitted", is_fitted(parameter)},
                       {"ci95", {known.low, known.high}},
                       {"unit", unit_of(parameter.key)}});
    }
    return all;
}

nlohmann::json as_json(const part_rms &rms)
{
    return {{"before", rms.before}, {"retuned", rms.retuned}, {"after", rms.after}, {"floor", rms.floor}};
}

/* What was counted in single samples was not fitted: no BIC and no gain belong to it. */
nlohmann::json as_json(const cause &known, block told_in)
{
    nlohmann::json json{{"effect", known.effect->name},
                        {"parameters", as_json(known.parameters)},
                        {"delta_bic", nullptr},
                        {"share_explained", known.share_explained},
                        {"shown_by", name_of(known.is_shown_by_force ? block::force : told_in)},
                        {"held_out_gain", nullptr}};
    if (!known.effect->is_of_single_samples) {
        json["delta_bic"] = known.delta_bic;
        json["held_out_gain"] = {{"value", known.held_out_gain},
                                 {"ci95", {known.held_out_gain_low, known.held_out_gain_high}}};
    }
    return json;
}

/* Of what is left: the class, if any, and where it lives, if it is more than noise. */
nlohmann::json left_as_json(const block_diagnosis &block, const record &data)
{
    nlohmann::json json{{"share", block.left}, {"depends", nullptr}, {"band_Hz", nullptr}, {"where", nullptr}};
    if (block.left > 0.0) {
        json["depends"] = error_class_names[static_cast<int>(block.left_class)];
    }
    if (has_rest(block)) {
        const error_place place = find_error_place(block, data);
        if (place.band) {
            json["band_Hz"] = {place.band->low_Hz, place.band->high_Hz};
        }
        json["where"] = {{"rows", place.state}, {"share", place.share}};
    }
    return json;
}

nlohmann::json as_json(const block_diagnosis &block, const record &data)
{
    nlohmann::json causes = nlohmann::json::array();
    for (const cause &known : block.causes) {
        causes.push_back(as_json(known, block.block));
    }
    nlohmann::json alternatives = nlohmann::json::array();
    for (const alternative &other : block.alternatives) {
        alternatives.push_back({{"effect", other.effect->name}, {"delta_bic", other.delta_bic}});
    }
    nlohmann::json ranking = nlohmann::json::array();
    for (const ranked &one : block.ranking) {
        ranking.push_back({{"round", one.round},
                           {"effect", one.effect->name},
                           {"delta_bic", one.delta_bic},
                           {"share_explained", one.share_explained}});
    }
    nlohmann::json tried = nlohmann::json::array();
    for (const effect *const one : block.tried) {
        tried.push_back(one->name);
    }
    return {{"block", name_of(block.block)},
            {"verdict", name_of(block.verdict)},
            {"tried", tried},
            {"ranking", ranking},
            {"causes", causes},
            {"alternatives", alternatives},
            {"doubts", block.doubts},
            {"base", as_json(block.base)},
            {"residual",
             {{"unit", block_units[static_cast<int>(block.block)]},
              {"fit", as_json(block.fit_rms)},
              {"held_out", as_json(block.held_out_rms)},
              {"floor_ci95", {interval_of_floor(block).low, interval_of_floor(block).high}},
              {"floor_is_measured", block.floor_is_measured}}},
            {"floor_noise",
             {{"ar", block.floor.ar},
              {"slow_decay", block.floor.slow_decay},
              {"slow_gain", block.floor.slow_gain},
              {"sigma", block.floor.sigma}}},
            {"left", left_as_json(block, data)}};
}

nlohmann::json as_json(const detectable_size &one)
{
    nlohmann::json others = nlohmann::json::array();
    for (const effect_value &other : one.others) {
        others.push_back({{"key", other.key}, {"value", other.value}, {"unit", unit_of(other.key)}});
    }
    const bool is_given = std::isfinite(one.given);
    return {{"effect", one.effect->name},
            {"key", one.key},
            {"value", one.value ? nlohmann::json(*one.value) : nlohmann::json()},
            {"given", is_given ? nlohmann::json(one.given) : nlohmann::json()},
            {"unit", unit_of(one.key)},
            {"others", others}};
}

nlohmann::json as_json(const next_experiment &next, const rig &given)
{
    const bool is_told = next.proposed.has_value();
    const auto if_told = [&](const auto &value) { return is_told ? nlohmann::json(value()) : nlohmann::json(); };
    return {{"file", if_told([] { return next_experiment_file; })},
            {"kind", if_told([&] { return kind_of(*next.proposed); })},
            {"excitation", if_told([&] { return words_of(*next.proposed, given); })},
            {"duration_s", if_told([&] { return next.proposed->duration_s; })},
            {"rivals", next.rivals},
            {"predicted_delta_bic", next.predicted_gap},
            {"why", next.why},
            {"calibration", next.calibration.empty() ? nlohmann::json() : nlohmann::json(next.calibration)}};
}

nlohmann::json as_json(const diagnosis &found, const diagnose_arguments &arguments, const rig &given)
{
    nlohmann::json json{{"verdict", name_of(found.verdict)},
                        {"causes", nlohmann::json::array()},
                        {"alternatives", nlohmann::json::array()},
                        {"next_experiment", found.next ? as_json(*found.next, given) : nlohmann::json()},
                        {"version", version()},
                        {"schema", 3}};
    json["block"] = found.located.empty() ? nlohmann::json() : nlohmann::json(found.located);
    json["residual"] = nlohmann::json::object();
    json["blocks"] = nlohmann::json::array();
    json["not_described"] = nlohmann::json::array();
    for (const block block : found.not_described) {
        json["not_described"].push_back(name_of(block));
    }
    json["not_tried"] = found.not_tried;
    json["detectable"] = nlohmann::json::array();
    for (const detectable_size &one : found.detectable) {
        json["detectable"].push_back(as_json(one));
    }
    for (const block_diagnosis &block : found.blocks) {
        nlohmann::json made = as_json(block, found.data);
        json["causes"].insert(json["causes"].end(), made["causes"].begin(), made["causes"].end());
        json["alternatives"].insert(json["alternatives"].end(), made["alternatives"].begin(),
                                    made["alternatives"].end());
        json["residual"][channel_of(block.block)] = made["residual"];
        json["blocks"].push_back(std::move(made));
    }
    json["inputs"] = {{{"role", "rig"}, {"path", arguments.rig}, {"hash", config_hash(given)}}};
    for (const input_file &input : found.inputs) {
        json["inputs"].push_back({{"role", input.role}, {"path", input.path}, {"hash", input.hash}});
    }
    json["overrides"] = arguments.overrides;
    json["without"] = arguments.without;
    json["period_ms"] = 1e3 * found.data.period_s;
    json["notes"] = found.notes;
    return json;
}

/* As printf's %g, which takes twice the time: a record has a million numbers. */
void add_number(std::string &text, double value, int digits)
{
    char number[40];
    const auto [end, error] =
        std::to_chars(number, number + sizeof number, value, std::chars_format::general, digits);
    (void)error; /* it has room for 24 characters */
    text.append(number, end);
}

/* Over time, for the report: the signals that were measured, and of every block what each row served for (0 nothing,
 * 1 fit, 2 held out) and its errors, measured less simulated. */
std::string series_csv(const diagnosis &found)
{
    const record &data = found.data;
    const std::vector<double> none;
    const std::pair<const char *, const std::vector<double> *> measured[] = {
        {"operator_force_N", &data.operator_force_N},
        {"operator_position_m", &data.operator_position_m},
        {"command_position_m", data.moves_as_measured() ? &none : &data.command_position_m},
        {"robot_position_m", &data.robot_position_m},
        {"force_N", &data.force_N}};
    std::string text = "t_s";
    for (const auto &[name, values] : measured) {
        text += values->empty() ? "" : "," + std::string(name);
    }
    for (const block_diagnosis &block : found.blocks) {
        const std::string name(name_of(block.block));
        const std::string unit = "_" + std::string(block_units[static_cast<int>(block.block)]);
        for (const char *const column : {"_use", "_error_before", "_error_after"}) {
            text += ',';
            text += name;
            text += column;
            text += std::string_view(column) == "_use" ? "" : unit;
        }
    }
    text += "\n";
    for (std::size_t n = 0; n < data.size(); n++) {
        add_number(text, data.time_s[n], 9);
        for (const auto &signal : measured) {
            if (!signal.second->empty()) {
                text += ',';
                add_number(text, (*signal.second)[n], 12);
            }
        }
        for (const block_diagnosis &block : found.blocks) {
            text += ',';
            text += std::to_string(static_cast<int>(block.uses[n]));
            for (const auto *const error : {&block.error_before, &block.error_after}) {
                text += ',';
                add_number(text, (*error)[n], 6);
            }
        }
        text += '\n';
    }
    return text;
}

constexpr const char *output_files[] = {"diagnosis.json", "given.toml", "extended.toml", "series.csv",
                                        next_experiment_file};

/* A diagnosis may take minutes: whether its files can be written is known before. Throws input_error. */
void refuse_unwritable(const std::string &folder)
{
    namespace fs = std::filesystem;
    std::error_code error;
    for (const char *const name : output_files) {
        if (fs::is_directory(fs::path(folder) / name, error)) {
            throw input_error(folder + "/" + name + ": is a folder, and a file is to be written there; move it");
        }
    }
    fs::path there = fs::absolute(folder, error);
    while (there.has_relative_path() && fs::symlink_status(there, error).type() == fs::file_type::not_found) {
        there = there.parent_path();
    }
    const bool is_folder = fs::is_directory(there, error);
    if (!is_folder || access(there.c_str(), W_OK | X_OK) != 0) {
        throw input_error("--out " + folder + ": " + there.string() +
                          (is_folder ? " is not writable" : " is no folder") +
                          (error ? ": " + error.message() : ""));
    }
}

std::vector<std::string> names_of_effects()
{
    std::vector<std::string> names;
    for (const effect &known : effect_library()) {
        names.emplace_back(known.name);
    }
    return names;
}

/* The first file appears when all are written: a disk that is full leaves those of an earlier diagnosis. */
void write_files(const std::string &folder, const diagnosis &found, const nlohmann::json &json)
{
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error) {
        throw input_error(folder + ": cannot be made: " + error.message());
    }
    std::deque<atomic_file> files;
    const auto write = [&](const std::string &name, const std::string &text) {
        files.emplace_back(folder + "/" + name).write(text);
    };
    write("diagnosis.json", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    /* A robot by itself stays one: with all keys stated its dead time would have to suit a loop. */
    const auto print = is_robot_alone(found.given) ? print_config : print_rig;
    write("given.toml", print(found.given));
    write("extended.toml", print(found.extended));
    write("series.csv", series_csv(found));
    std::vector<std::string> stale = {"report.html", "report.png"}; /* of an earlier diagnosis */
    if (found.next && found.next->proposed) {
        write(next_experiment_file, profile_csv(found.given, *found.next->proposed));
    } else {
        stale.emplace_back(next_experiment_file);
    }
    for (atomic_file &file : files) {
        file.close();
    }
    for (atomic_file &file : files) {
        file.finish();
    }
    for (const std::string &name : stale) {
        std::filesystem::remove(std::filesystem::path(folder) / name, error);
    }
}

} // namespace

int diagnose_command(const diagnose_arguments &arguments)
{
    diagnosis_request request;
    request.records = arguments.records;
    request.validation = arguments.validation;
    request.repetition = arguments.repetition;
    request.standstill = arguments.standstill;
    request.limit_s = arguments.limit_s;
    request.rig = load_rig(arguments.rig, arguments.overrides);
    refuse_arm(request.rig);
    refuse_beam(request.rig);
    for (const std::string &name : arguments.without) {
        if (find_effect(name) == nullptr) {
            const std::string meant = did_you_mean(names_of_effects(), name);
            throw input_error("--without " + name + ": there is no such effect" + (meant.empty() ? ";" : meant) +
                              " berth effects lists them");
        }
        request.options.without.push_back(name);
    }
    refuse_unwritable(arguments.out_folder);
    const diagnosis found = [&] {
        const progress_line line;
        request.progress = [&](const std::string &what) { line.show(what); };
        return diagnose(request);
    }();

    const nlohmann::json json = as_json(found, arguments, found.given);
    write_files(arguments.out_folder, found, json);
    if (arguments.json) {
        print_json(json);
        return 0;
    }
    print_diagnosis(found, arguments.out_folder);
    std::printf("written to %s: diagnosis.json, extended.toml, given.toml, series.csv\n"
                "report: build/berth report %s\n",
                arguments.out_folder.c_str(), arguments.out_folder.c_str());
    return 0;
}

} // namespace berth
