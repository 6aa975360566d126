/* How the subcommands that read a log tell how much of it is whole. */
#ifndef SIM_HAL_CLI_LOG_CONDITION_H
#define SIM_HAL_CLI_LOG_CONDITION_H

#include <cstdint>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "../log/log_damage.h"

namespace berth
{

constexpr int exit_damaged = 2;

/* The keys checksums, cut, damage and whole_until_s. */
nlohmann::json as_json(const log_condition &condition);

/* On standard error, if there is damage. `ticks`: as many were read before it. */
void print_damage(const std::string &log, const log_condition &condition, std::int64_t ticks);

/* ", at 1.2 s", or empty: not known. */
std::string time_of_end(const log_condition &condition);

} // namespace berth

#endif
