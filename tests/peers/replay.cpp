/* The two commands of `berth` that another architecture is asked for, without what they would bring along: maps and
 * diagnosis take longest to build. Words and exit codes are those of `berth`.
 *
 *   replay run RIG --out FOLDER --json [--set KEY=VALUE]...
 *   replay replay LOG --json */
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "../../firmware/loop.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/manipulator_stand_in.h"
#include "../../sim_hal/hil/sim_hal.h"
#include "../../sim_hal/log/replay.h"

namespace
{

int run(const char *name, const std::vector<std::string> &words)
{
    std::string folder = ".";
    std::vector<std::string> overrides;
    for (std::size_t i = 0; i + 1 < words.size(); i++) {
        if (words[i] == "--out") {
            folder = words[i + 1];
        } else if (words[i] == "--set") {
            overrides.push_back(words[i + 1]);
        }
    }
    const berth::rig rig = berth::load_rig(name, overrides);
    berth::sim_options options;
    options.log_path = folder + "/" + rig.name + ".ulg";
    struct hal *hal = berth::sim_open(rig, options);
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &rig.firmware);
    berth::manipulator_stand_in manipulator(rig);
    while (app->supervisor.state != SUPERVISOR_STOPPED && loop_tick(hal, app.get()) == HAL_OK) {
        manipulator.replace(*app);
    }
    std::printf("{\"log\": \"%s\", \"ticks\": %lld, \"config_hash\": \"%s\"}\n", options.log_path.c_str(),
                static_cast<long long>(app->recorder.tick.index) + 1, berth::config_hash(rig).c_str());
    return hal_close(hal) == HAL_OK ? 0 : 2;
}

int replay(const char *log)
{
    const berth::replay_result result = berth::replay_log(log);
    std::printf("{\"log\": \"%s\", \"equal\": %s, \"ticks\": %lld, \"gap\": %s", log,
                result.is_equal ? "true" : "false", static_cast<long long>(result.ticks),
                result.has_gap ? "true" : "false");
    if (!result.is_equal) {
        std::printf(", \"first_difference\": {\"tick\": %lld, \"field\": \"%s\"}",
                    static_cast<long long>(result.tick), result.field.c_str());
    }
    std::printf("}\n");
    return result.is_equal ? 2 * static_cast<int>(result.has_gap || result.condition.damage) : 1;
}

} // namespace

int main(int argc, char **argv)
{
    try {
        if (argc >= 3 && std::strcmp(argv[1], "run") == 0) {
            return run(argv[2], {argv + 3, argv + argc});
        }
        if (argc >= 3 && std::strcmp(argv[1], "replay") == 0) {
            return replay(argv[2]);
        }
        std::fprintf(stderr, "usage: replay run RIG --out FOLDER --json [--set KEY=VALUE]... | replay replay LOG\n");
    } catch (const berth::input_error &error) {
        std::fprintf(stderr, "replay: %s\n", error.what());
    }
    return 2;
}
