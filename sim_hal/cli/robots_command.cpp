#include <unistd.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "../../hal/rig/robot_file.h"
#include "commands.h"
#include "json_or_null.h"
#include "short_number.h"
#include "terminal.h"

namespace berth
{

namespace
{

constexpr const char *rigs_own = "the rig's";
constexpr const char *columns = "%-13s  %-9s  %-10s  %-9s  %s\n";
constexpr std::size_t source_column = 13 + 2 + 9 + 2 + 10 + 2 + 9 + 2;
constexpr std::size_t source_width_usual = 66;
constexpr std::size_t source_width_min = 20;

nlohmann::json as_json(const robot_preset &robot)
{
    nlohmann::json json;
    json["name"] = robot.name;
    json["description"] = robot.description;
    json["source"] = robot.source;
    json["assumed"] = robot.assumed;
    json["period_ms"] = or_null(robot.period_ms);
    json["dead_time_ms"] = nullptr;
    if (robot.dead_time_ms) {
        json["dead_time_ms"] = {robot.dead_time_ms->from, robot.dead_time_ms->to};
    }
    json["dead_time_periods"] = or_null(robot.dead_time_periods);
    json["force_delay_ms"] = or_null(robot.force_delay_ms);
    json["plus_drive_lag"] = robot.plus_drive_lag;
    return json;
}

std::string ms_text(const std::optional<double> &value)
{
    return value ? short_number(*value) + " ms" : rigs_own;
}

std::string dead_time_text(const robot_preset &robot)
{
    std::string text = rigs_own;
    if (robot.dead_time_ms) {
        const auto [from, to] = *robot.dead_time_ms;
        text = (from < to ? short_number(from) + "-" : "") + short_number(to) + " ms";
    } else if (robot.dead_time_periods) {
        text = short_number(*robot.dead_time_periods) + " T";
    }
    return text + (robot.plus_drive_lag ? " + lag" : "");
}

/* As wide as a terminal leaves it. */
std::size_t source_width()
{
    const std::size_t width = terminal_width(STDOUT_FILENO);
    return width < source_column + source_width_min ? source_width_usual : width - source_column;
}

/* In lines of at most source_width() bytes, all but the first under the column's head. */
std::string in_column(const std::string &text)
{
    const std::size_t width = source_width();
    std::istringstream words(text);
    std::string result;
    std::size_t used = 0;
    for (std::string word; words >> word; used += word.size()) {
        if (used > 0 && used + 1 + word.size() > width) {
            result += "\n" + std::string(source_column, ' ');
            used = 0;
        } else if (used > 0) {
            result += ' ';
            used++;
        }
        result += word;
    }
    return result;
}

void print_line(const robot_preset &robot)
{
    const std::string text = robot.source + (robot.assumed.empty() ? "" : " Assumed: " + robot.assumed);
    std::printf(columns, robot.name.c_str(), ms_text(robot.period_ms).c_str(), dead_time_text(robot).c_str(),
                ms_text(robot.force_delay_ms).c_str(), in_column(text).c_str());
}

} // namespace

int robots_command(const std::string &name_or_path, bool json)
{
    if (!name_or_path.empty()) {
        const robot_preset robot = load_robot(name_or_path);
        if (json) {
            print_json(as_json(robot));
        } else {
            std::fputs(robot.text.c_str(), stdout);
        }
        return 0;
    }
    nlohmann::json list = nlohmann::json::array();
    if (!json) {
        std::printf(columns, "robot", "period T", "dead time", "force", "source");
    }
    for (const auto &shipped : shipped_robots()) {
        const robot_preset robot = load_robot(shipped.name);
        list.push_back(as_json(robot));
        if (!json) {
            print_line(robot);
        }
    }
    if (json) {
        print_json({{"robots", list}});
    }
    return 0;
}

} // namespace berth
