#include "log_condition.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "json_or_null.h"

namespace berth
{

nlohmann::json as_json(const log_condition &condition)
{
    nlohmann::json object = {{"checksums", condition.has_checksums},
                             {"cut", condition.is_cut},
                             {"damage", nullptr},
                             {"whole_until_s", or_null(condition.whole_until_s)}};
    if (const auto &damage = condition.damage) {
        object["damage"] = {{"from_byte", damage->bytes.from_byte},
                            {"to_byte", damage->bytes.to_byte},
                            {"last_whole_s", or_null(damage->last_whole_s)},
                            {"whole_again_s", or_null(damage->whole_again_s)}};
    }
    return object;
}

void print_damage(const std::string &log, const log_condition &condition, std::int64_t ticks)
{
    if (condition.damage) {
        std::fprintf(stderr, "berth: %s: %s; what is before that is whole: %lld ticks\n", log.c_str(),
                     text_of(*condition.damage).c_str(), static_cast<long long>(ticks));
    }
}

std::string time_of_end(const log_condition &condition)
{
    char text[40] = "";
    if (condition.whole_until_s) {
        std::snprintf(text, sizeof text, ", at %.4f s", *condition.whole_until_s);
    }
    return text;
}

} // namespace berth
