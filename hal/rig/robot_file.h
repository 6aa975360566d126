/* Robot presets: what is reported of a robot's interface, as a TOML file. A preset has the keys of a rig file that
 * belong to a robot and its loop, and it may say
 *
 *   source = "..."                     who reports it; every preset has one
 *   assumed = "..."                    what the preset adds to the report
 *   loop.period_ms = 4.0               instead of loop.rate_Hz
 *   robot.dead_time_ms = [40.0, 80.0]  where a range is reported
 *   robot.dead_time_periods = 3.0      instead of it, in periods of whatever rig it is applied to
 *   robot.plus_drive_lag = true        the drive's lag comes on top and is not included
 */
#ifndef HAL_RIG_ROBOT_FILE_H
#define HAL_RIG_ROBOT_FILE_H

#include <optional>
#include <string>
#include <vector>

#include "rig_file.h"

namespace berth
{

struct range_ms {
    double from;
    double to;
};

struct robot_preset {
    /* A key of the rig, its value as text, and where the preset states it. */
    struct setting {
        std::string path;
        std::string text;
        std::string where;
    };

    std::string name;
    std::string description;
    std::string source;
    std::string assumed;
    std::optional<double> period_ms;
    std::optional<range_ms> dead_time_ms; /* one value: from it to itself */
    std::optional<double> dead_time_periods;
    bool plus_drive_lag = false;
    std::optional<double> force_delay_ms; /* sensor.delay_ms */
    std::vector<setting> settings; /* what the rig gets; of a range, the upper end; not what is stated in periods */
    std::string text;              /* the file */
};

/* A preset shipped with the program. */
const std::vector<shipped_file> &shipped_robots();

/* A shipped preset by name, or a file by path. Throws input_error. */
robot_preset load_robot(const std::string &name_or_path);

/* The same from text; `origin` stands for the file's name in messages. */
robot_preset parse_robot(const std::string &text, const std::string &origin);

/* The dead times that are reported for a rig loaded with this preset and these overrides. Nothing: the preset states
 * no range, or an override puts a value in its place. */
std::optional<range_ms> dead_time_band(const robot_preset &robot, const std::vector<std::string> &overrides);

/* This dead time along every axis of the robot. */
void show_dead_time(rig &rig, double dead_time_ms);

} // namespace berth

#endif
