#include <cstdio>
#include <nlohmann/json.hpp>

#include "../hil/deadtime.h"
#include "../hil/sim_hal.h"
#include "commands.h"
#include "robot_choice.h"

namespace berth
{

namespace
{

constexpr double step_m = 1e-3;

/* Long enough for the dead time and for the transfer behaviour to settle. */
double watch_s(const rig &rig)
{
    const double settle_s =
        rig.has_transfer_behaviour()
            ? 5.0 / (rig.robot.transfer_frequency_Hz * std::max(0.05, rig.robot.transfer_damping_ratio))
            : 0.0;
    return 2e-3 * rig.robot.dead_time_ms + settle_s + 0.1;
}

} // namespace

int deadtime_command(const rig_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    rig rig = chosen.rig;
    rig.run.duration_s = never; /* as long as the measurement takes */
    struct hal *hal = sim_open(rig);
    deadtime_measurement measured;
    const bool is_drive = rig.firmware.robot_channel.profile == ROBOT_PROFILE_CIA402;
    const hal_status status = is_drive ? measure_drive_deadtime(hal, rig.firmware, step_m, watch_s(rig), measured)
                                       : measure_deadtime(hal, rig.firmware, step_m, watch_s(rig), measured);
    hal_close(hal);
    if (status != HAL_OK) {
        std::fprintf(stderr, "berth: %s: the robot's feedback does not come; look at bus and robot of the rig\n",
                     arguments.rig.c_str());
        return 3;
    }
    const double sync_wait_ms = 1e-6 * static_cast<double>(sync_wait_ns(rig));
    if (arguments.json) {
        print_json({{"rig", rig.name},
                    {"robot", robot_as_json(chosen)},
                    {"command_to_motion_ms", 1e3 * measured.command_to_motion_s},
                    {"first_motion_ms", 1e3 * measured.first_motion_s},
                    {"configured_ms", 1e-6 * static_cast<double>(command_to_motion_ns(rig))},
                    {"sync_wait_ms", sync_wait_ms},
                    {"period_ms", 1e3 * config_period_s(&rig.firmware)},
                    {"step", measured.step}});
    } else {
        char waits[80] = "";
        if (is_drive) {
            std::snprintf(waits, sizeof waits, ", and %g ms until the SYNC at which a setpoint acts", sync_wait_ms);
        }
        std::printf("%s: a setpoint step of 1 mm is displayed %.4f ms later (configured: %g ms%s%s)\n",
                    rig.name.c_str(), 1e3 * measured.command_to_motion_s, rig.robot.dead_time_ms, waits,
                    rig.robot.interpolation == interpolation::hold ? "; \"hold\" is seen to one tick" : "");
        if (chosen.robot) {
            std::printf("  robot %s\n", robot_sentence(robot_as_json(chosen)).c_str());
        }
    }
    return 0;
}

} // namespace berth
