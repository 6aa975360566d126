#include "log_damage.h"

#include <cstdio>

#include <nlohmann/json.hpp>

namespace berth
{

nlohmann::json as_json(const std::optional<ulog_reader::damage> &damage)
{
    return damage ? nlohmann::json{{"from_byte", damage->from_byte}, {"to_byte", damage->to_byte}}
                  : nlohmann::json();
}

void print_damage(const std::string &log, const ulog_reader::damage &damage, std::int64_t ticks)
{
    std::fprintf(stderr, "berth: %s: %s: %lld ticks\n", log.c_str(), damage.text().c_str(),
                 static_cast<long long>(ticks));
}

} // namespace berth
