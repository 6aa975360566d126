/* The frames of a log as text, one file per bus, in the format of `candump -L`: `cantools decode`,
 * canplayer and, by the ending .log, python-can take it. */
#ifndef SIM_HAL_LOG_CANDUMP_H
#define SIM_HAL_LOG_CANDUMP_H

#include <string>
#include <vector>

namespace berth
{

/* Writes STEM.robot.candump.log and STEM.sensor.candump.log, STEM being `log_path` without its ending; returns their
 * paths. Interfaces are named can0 (robot) and can1 (sensor). A file appears whole or not at all. Throws
 * input_error. */
std::vector<std::string> export_candump(const std::string &log_path);

/* Those paths, robot before sensor. */
std::vector<std::string> candump_paths(const std::string &log_path);

} // namespace berth

#endif
