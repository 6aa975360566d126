/* What a bounce of a rig in contact does, as told by `eigen` and `limits`. */
#ifndef SIM_HAL_CLI_BOUNCE_REPORT_H
#define SIM_HAL_CLI_BOUNCE_REPORT_H

#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "../bounce.h"

namespace berth
{

struct bounce_answer {
    std::optional<played_bounce> own; /* nothing: no tool in contact, or one that never reaches the surface */
    std::vector<std::pair<std::string_view, std::optional<bounce_limit>>> limits; /* by the parameter's key */
};

/* Also looks for the values of these parameters at which a bounce gains energy. */
bounce_answer answer_bounce(const rig &rig, const std::vector<std::string_view> &keys);

void print_bounce(const bounce_answer &answer);
nlohmann::json bounce_json(const bounce_answer &answer);

} // namespace berth

#endif
