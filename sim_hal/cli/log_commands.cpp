#include <cstdio>
#include <nlohmann/json.hpp>

#include "../log/candump.h"
#include "../log/replay.h"
#include "commands.h"
#include "log_condition.h"

namespace berth
{

namespace
{
constexpr int exit_different = 1;
constexpr int exit_incomplete = 2; /* the log lacks records */
} // namespace

void print_json(const nlohmann::json &object)
{
    std::printf("%s\n", object.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
}

/* Whether damage may be the cause of a difference. */
static const char *about_damage(const log_condition &condition)
{
    if (!condition.has_checksums) {
        return "the log has no checksums: damage may be the cause";
    }
    return condition.is_cut ? "the log is cut: damage behind its last checksum may be the cause"
                            : "the log is not damaged there: its checksums fit";
}

static int exit_code_of(const replay_result &result)
{
    if (!result.is_equal) {
        return exit_different;
    }
    return result.has_gap || result.condition.damage ? exit_incomplete : 0;
}

int replay_command(const std::string &log, bool json)
{
    const replay_result result = replay_log(log);
    if (result.has_gap) {
        std::fprintf(stderr, "berth: %s: records are missing after tick %lld: replayed up to there\n", log.c_str(),
                     static_cast<long long>(result.tick));
    }
    print_damage(log, result.condition, result.ticks);
    if (json) {
        nlohmann::json object = as_json(result.condition);
        object.update({{"log", log}, {"equal", result.is_equal}, {"ticks", result.ticks}, {"gap", result.has_gap}});
        if (!result.is_equal) {
            object["first_difference"] = {{"tick", result.tick},
                                          {"field", result.field},
                                          {"recorded", result.recorded},
                                          {"replayed", result.replayed}};
        }
        print_json(object);
        return exit_code_of(result);
    }
    if (!result.is_equal) {
        std::printf("%s: differs at tick %lld in %s: recorded %s, replayed %s\n", log.c_str(),
                    static_cast<long long>(result.tick), result.field.c_str(), result.recorded.c_str(),
                    result.replayed.c_str());
        std::printf("%s\n", about_damage(result.condition));
        return exit_different;
    }
    std::printf("%s: %lld ticks replayed, equal bit for bit\n", log.c_str(), static_cast<long long>(result.ticks));
    if (result.condition.is_cut) {
        std::printf("the file is cut: replayed up to the last whole tick%s\n",
                    time_of_end(result.condition).c_str());
    }
    return exit_code_of(result);
}

int candump_command(const std::string &log, bool json)
{
    const std::vector<std::string> paths = export_candump(log);
    if (json) {
        print_json({{"log", log}, {"candumps", paths}});
        return 0;
    }
    for (const std::string &path : paths) {
        std::printf("%s\n", path.c_str());
    }
    return 0;
}

int rigs_command(bool json)
{
    nlohmann::json list = nlohmann::json::array();
    for (const auto &shipped : shipped_rigs()) {
        const rig rig = load_rig(shipped.name);
        list.push_back({{"name", rig.name}, {"description", rig.description}});
        if (!json) {
            std::printf("%-20s %s\n", rig.name.c_str(), rig.description.c_str());
        }
    }
    if (json) {
        print_json({{"rigs", list}});
    }
    return 0;
}

} // namespace berth
