/* The scenarios of this folder in simulation; tests/target plays the same files on real buses and lines. */
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <toml++/toml.h>
#include <vector>

#include "../support/closed_loop.h"

namespace berth
{

namespace
{

constexpr double duration_s = 3.0;

using action = std::function<void(struct hal *)>;

action input(hal_line line, std::uint8_t level)
{
    return [=](struct hal *hal) { sim_set_input(hal, line, level); };
}

action robot_silent(bool is_silent)
{
    return [=](struct hal *hal) {
        sim_rig(hal).set_robot_silent(is_silent);
        sim_rig(hal).operators().set_silent(is_silent);
    };
}

action sensor_silent(bool is_silent)
{
    return [=](struct hal *hal) { sim_rig(hal).force_sensor().set_silent(is_silent); };
}

action error_frame(int flags)
{
    return [=](struct hal *hal) {
        const hal_frame frame{0, 0, HAL_BUS_ROBOT, 8, static_cast<std::uint8_t>(flags), 0, {}};
        sim_rig(hal).bus(HAL_BUS_ROBOT).transmit_to_loop(frame, sim_rig(hal).now_ns());
    };
}

/* As if it came from the drive, node 1. */
action drive_frame(std::uint32_t id, const std::vector<std::uint8_t> &data)
{
    return [=](struct hal *hal) {
        hal_frame frame{0, id, HAL_BUS_ROBOT, static_cast<std::uint8_t>(data.size()), 0, 0, {}};
        std::copy(data.begin(), data.end(), frame.data);
        sim_rig(hal).bus(HAL_BUS_ROBOT).transmit_to_loop(frame, sim_rig(hal).now_ns());
    };
}

const std::map<std::string, action> actions = {
    {"press_emergency_stop", input(HAL_LINE_EMERGENCY_STOP, 1)},
    {"release_emergency_stop", input(HAL_LINE_EMERGENCY_STOP, 0)},
    {"enable_off", input(HAL_LINE_ENABLE, 0)},
    {"enable_on", input(HAL_LINE_ENABLE, 1)},
    {"sensor_silent", sensor_silent(true)},
    {"sensor_back", sensor_silent(false)},
    {"robot_silent", robot_silent(true)},
    {"robot_back", robot_silent(false)},
    {"bus_off", error_frame(HAL_FRAME_ERROR | HAL_FRAME_BUS_OFF)},
    {"error_passive", error_frame(HAL_FRAME_ERROR)},
    {"drive_emergency", drive_frame(0x081, {0x10, 0x23, 0x03, 0, 0, 0, 0, 0})},
    {"drive_boot_up", drive_frame(0x701, {0})},
};

std::vector<std::string> words(const toml::table &scenario, const char *key)
{
    std::vector<std::string> result;
    for (const toml::node &word : *scenario[key].as_array()) {
        result.push_back(word.value<std::string>().value());
    }
    return result;
}

std::vector<std::filesystem::path> scenario_files()
{
    std::vector<std::filesystem::path> files;
    for (const auto &entry : std::filesystem::directory_iterator("tests/scenarios")) {
        if (entry.path().extension() == ".toml") {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

void play(const toml::table &scenario, const std::string &profile)
{
    CAPTURE(profile);
    closed_loop loop("ess", {"run.duration_s=" + std::to_string(duration_s), "robot_channel.profile=" + profile});
    std::vector<std::string> states = {supervisor_state_name(SUPERVISOR_START)};
    std::size_t next = 0;
    const toml::array &events = *scenario["events"].as_array();
    while (loop.tick()) {
        const std::string state = supervisor_state_name(loop.app().supervisor.state);
        if (state != states.back()) {
            states.push_back(state);
        }
        const double now_s = 1e-9 * static_cast<double>(loop.app().recorder.tick.scheduled_ns);
        while (next < events.size() && now_s >= events[next].at_path("at_s").value<double>()) {
            actions.at(events[next].at_path("do").value<std::string>().value())(loop.hal());
            next++;
        }
    }
    CHECK(next == events.size());
    CHECK(states == words(scenario, "states"));
    CHECK(stop_cause_name(loop.app().supervisor.stop_cause) == scenario["stop_cause"].value<std::string>());
}

} // namespace

TEST_CASE("scenarios: what goes wrong outside leads to the documented state")
{
    int played = 0;
    for (const std::filesystem::path &file : scenario_files()) {
        const toml::table scenario = toml::parse_file(file.string());
        if (scenario["where"].value_or(std::string("both")) == "both") {
            CAPTURE(file.stem().string());
            for (const std::string profile : {"berth", "cia402"}) {
                if (scenario["profile"].value_or(profile) == profile) {
                    play(scenario, profile);
                }
            }
            played++;
        }
    }
    CHECK(played > 0);
}

} // namespace berth
