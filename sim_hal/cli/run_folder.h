/* Where runs are kept: build/runs/RIG/TIME, with a link `latest` beside, and a page of all of them. */
#ifndef SIM_HAL_CLI_RUN_FOLDER_H
#define SIM_HAL_CLI_RUN_FOLDER_H

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "../../hal/rig/rig.h"

namespace berth
{

constexpr const char *kept_runs = "build/runs";

/* Makes a folder for this run, named after the local time: 2026-11-29T23-40-05, with -2 behind if there is one of
 * this second. A number is never below that of an earlier run. Throws input_error. */
std::string make_run_folder(const std::string &rig_name);

/* Puts the run's result beside its log, points `latest` to the newest run by its start, removes this rig's oldest
 * runs beyond `keep` (0: none) and writes the page of all runs: its path is returned. */
std::string keep_run(const std::string &folder, const nlohmann::json &result, const rig &rig, std::int64_t keep);

/* The log in a run's folder, or the path itself; a rig's name is that of its newest run; behind the link `latest`,
 * by the name of the run that it points to now. Throws input_error where the folder has no log, or several. */
std::string log_of(const std::string &path);

/* After a report was made of a kept run: its link comes onto the page. Other logs are left alone. */
void refresh_run_index(const std::string &log);

} // namespace berth

#endif
