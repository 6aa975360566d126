/* berth-rig: the simulated rig at the other end of real buses, see far_end.h. */
#include <atomic>
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "../../hal/linux/hardware_error.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/version.h"
#include "far_end.h"

namespace
{

constexpr int exit_usage_or_input = 2;
constexpr int exit_hardware = 3;

std::atomic<bool> stop_wanted{false};

extern "C" void on_stop_signal(int)
{
    stop_wanted.store(true, std::memory_order_relaxed);
}

int run(int argc, char **argv)
{
    std::string rig_name;
    std::vector<std::string> overrides;
    berth::far_end_options options;
    CLI::App app{"berth-rig: the simulated rig at the other end of real buses, in real time"};
    app.set_version_flag("--version", std::string("berth ") + berth::version());
    app.add_option("RIG", rig_name, "a shipped rig or the path of a rig file")->required();
    app.add_option("--set", overrides, "override a key of the rig: section.key=value; may be repeated")
        ->type_name("KEY=VALUE")
        ->take_all()
        ->allow_extra_args(false);
    app.add_option("--robot", options.robot_interface, "CAN interface; default: target.robot_interface");
    app.add_option("--sensor", options.sensor_interface, "CAN interface; default: target.sensor_interface");
    app.add_option("--lead-us", options.lead_us, "how long before a tick its frames are sent")
        ->capture_default_str()
        ->check(CLI::Range(0, 100000));
    app.add_option("--priority", options.priority, "SCHED_FIFO priority; 0: none")
        ->capture_default_str()
        ->check(CLI::Range(0, 98));
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        if (error.get_exit_code() == 0) {
            return app.exit(error);
        }
        throw berth::input_error(std::string("berth-rig: ") + error.what() + "; see --help");
    }
    const berth::rig rig = berth::load_rig(rig_name, overrides);
    const berth::target_rig &target = rig.target;
    options.robot_interface = options.robot_interface.empty() ? target.robot_interface : options.robot_interface;
    options.sensor_interface = options.sensor_interface.empty() ? target.sensor_interface : options.sensor_interface;
    std::signal(SIGINT, on_stop_signal);
    std::signal(SIGTERM, on_stop_signal);

    berth::far_end far_end(rig, options);
    std::printf("%s: waits for a loop on %s\n", rig.name.c_str(), options.robot_interface.c_str());
    std::fflush(stdout);
    const berth::far_end_result result = far_end.run(stop_wanted);
    const std::uint64_t not_sent = result.robot_bus.not_sent + result.sensor_bus.not_sent;
    std::printf("%s: %lld periods, %lld late; %llu setpoints; %llu frames not sent\n", rig.name.c_str(),
                static_cast<long long>(result.periods), static_cast<long long>(result.late_periods),
                static_cast<unsigned long long>(result.setpoints), static_cast<unsigned long long>(not_sent));
    return 0;
}

} // namespace

int main(int argc, char **argv)
{
    try {
        return run(argc, argv);
    } catch (const berth::input_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return exit_usage_or_input;
    } catch (const berth::hardware_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return exit_hardware;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "berth-rig: internal error: %s\n", error.what());
        return 1;
    }
}
