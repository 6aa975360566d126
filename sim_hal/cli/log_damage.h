/* How the subcommands that read a log tell of its damage. */
#ifndef SIM_HAL_CLI_LOG_DAMAGE_H
#define SIM_HAL_CLI_LOG_DAMAGE_H

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "../log/ulog_reader.h"

namespace berth
{

/* null: there is none. */
nlohmann::json as_json(const std::optional<ulog_reader::damage> &damage);

/* On standard error; `ticks`: as many are whole before it. */
void print_damage(const std::string &log, const ulog_reader::damage &damage, std::int64_t ticks);

} // namespace berth

#endif
