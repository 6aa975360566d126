/* The record of the stages as a JSON file. */
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "commissioning.h"
#include "rig_file.h"

namespace berth
{

namespace
{

constexpr int record_schema = 1;

template <std::size_t count>
std::size_t place_in(const std::array<std::string_view, count> &names, const nlohmann::json &word)
{
    const auto name = word.get<std::string>();
    for (std::size_t i = 0; i < count; i++) {
        if (names[i] == name) {
            return i;
        }
    }
    throw input_error("\"" + name + "\" is no word of it");
}

nlohmann::json or_null(const std::optional<double> &value)
{
    return value ? nlohmann::json(*value) : nlohmann::json();
}

std::optional<double> optional_number(const nlohmann::json &value)
{
    return value.is_null() ? std::optional<double>() : value.get<double>();
}

nlohmann::json as_json(const stage_entry &entry)
{
    nlohmann::json values = nlohmann::json::array();
    for (const stage_value &value : entry.values) {
        values.push_back({{"name", value.name},
                          {"unit", value.unit},
                          {"measured", value.measured},
                          {"assumed", or_null(value.assumed)},
                          {"uncertainty", or_null(value.uncertainty)}});
    }
    nlohmann::json proposed = nlohmann::json::object();
    for (const auto &[key, value] : entry.proposed) {
        proposed[key] = value;
    }
    return {{"stage", name_of(entry.stage)},
            {"outcome", outcome_names[static_cast<std::size_t>(entry.outcome)]},
            {"because", entry.because},
            {"time", entry.time},
            {"config_hash", entry.configuration},
            {"log", entry.log},
            {"values", values},
            {"proposed", proposed}};
}

stage_entry entry_of(const nlohmann::json &json)
{
    stage_entry entry;
    entry.stage = static_cast<stage>(place_in(stage_names, json.at("stage")));
    entry.outcome = static_cast<stage_outcome>(place_in(outcome_names, json.at("outcome")));
    entry.because = json.at("because");
    entry.time = json.at("time");
    entry.configuration = json.at("config_hash");
    entry.log = json.at("log");
    for (const nlohmann::json &value : json.at("values")) {
        entry.values.push_back({value.at("name"), value.at("unit"), value.at("measured").get<double>(),
                                optional_number(value.at("assumed")), optional_number(value.at("uncertainty"))});
    }
    for (const auto &[key, value] : json.at("proposed").items()) {
        entry.proposed.emplace_back(key, value.get<double>());
    }
    return entry;
}

} // namespace

std::string print_commissioning(const commissioning &record)
{
    nlohmann::json entries = nlohmann::json::array();
    for (const stage_entry &entry : record.entries) {
        entries.push_back(as_json(entry));
    }
    const nlohmann::json json{{"schema", record_schema},
                              {"rig", record.rig},
                              {"place", place_names[static_cast<std::size_t>(record.place)]},
                              {"entries", entries}};
    return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

commissioning parse_commissioning(const std::string &text, const std::string &origin)
{
    try {
        const nlohmann::json json = nlohmann::json::parse(text);
        if (json.at("schema") != record_schema) {
            throw input_error("its schema is unknown");
        }
        commissioning record;
        record.rig = json.at("rig");
        record.place = static_cast<commissioning_place>(place_in(place_names, json.at("place")));
        for (const nlohmann::json &entry : json.at("entries")) {
            record.entries.push_back(entry_of(entry));
        }
        return record;
    } catch (const std::exception &error) {
        throw input_error(origin + ": is no record of commissioning (" + error.what() +
                          "); move it away to begin with the first stage");
    }
}

commissioning load_commissioning(const std::string &path, const std::string &rig,
                                 std::optional<commissioning_place> place)
{
    std::error_code error;
    if (!std::filesystem::exists(path, error)) {
        return {rig, place.value_or(commissioning_place::simulated), {}};
    }
    commissioning record = parse_commissioning(read_file(path, written_bytes_max), path);
    if (record.rig != rig || record.place != place.value_or(record.place)) {
        throw input_error(path + ": is the record of rig " + record.rig + ", " +
                          std::string(place_names[static_cast<std::size_t>(record.place)]) + ", and this is " + rig +
                          ", " + std::string(place_names[static_cast<std::size_t>(place.value_or(record.place))]) +
                          "; name another file with --record");
    }
    return record;
}

void save_commissioning(const std::string &path, const commissioning &record)
{
    const std::string written = path + ".new";
    std::ofstream file(written, std::ios::binary);
    file << print_commissioning(record);
    file.close();
    if (!file || std::rename(written.c_str(), path.c_str()) != 0) {
        throw input_error(path + ": the record of commissioning cannot be written; name another file with --record");
    }
}

} // namespace berth
