/* How far each parameter of a rig may go, and which rates are stable, as told by `berth limits`. */
#ifndef SIM_HAL_CLI_PARAMETER_REPORT_H
#define SIM_HAL_CLI_PARAMETER_REPORT_H

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "../stability/limits.h"

namespace berth
{

/* "[4, 8]"; of one that is a single value to all digits "4 alone". */
std::string interval_text(const stable_interval &interval);

nlohmann::json intervals_json(const std::vector<stable_interval> &intervals);
nlohmann::json parameter_json(const parameter_limits &parameter);
nlohmann::json rates_json(const std::vector<rate_verdict> &rates);

/* A table of all parameters, with the mode that is lost or regained at each limit, and how finely it was searched.
 */
void print_parameters(const std::vector<parameter_limits> &parameters, const scan &how);

/* `which`: a heading that says what stays as it is while the rate changes. */
void print_rates(const char *which, const std::vector<rate_verdict> &rates);

} // namespace berth

#endif
