/* The rig of a command line, and the robot preset that it names. */
#ifndef SIM_HAL_CLI_ROBOT_CHOICE_H
#define SIM_HAL_CLI_ROBOT_CHOICE_H

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "../../hal/rig/robot_file.h"
#include "commands.h"

namespace berth
{

struct chosen_rig {
    berth::rig rig; /* with the upper end of the band */
    std::optional<robot_preset> robot;
    std::optional<range_ms> dead_time_band;

    /* Only where there is a band. */
    berth::rig at_lower_end() const;
};

/* Rig file, then preset, then overrides, then jitter and seed. Throws input_error. */
chosen_rig choose_rig(const rig_arguments &arguments);
chosen_rig choose_rig(const varying_arguments &arguments);

/* What commands tell of the preset; null without one. */
nlohmann::json robot_as_json(const chosen_rig &chosen);

/* The text of it in a log, and back; `path` is the log's. Throws input_error where it is damaged. */
std::string robot_as_text(const chosen_rig &chosen);
nlohmann::json recorded_robot(const std::string &text, const std::string &path);

/* The same in a sentence, such as "abb-egm: period 4 ms, dead time 80 ms, the upper end of the reported 40 to 80
 * ms". */
std::string robot_sentence(const nlohmann::json &robot);

} // namespace berth

#endif
