/* One stage on the simulated rig, whose hardware may differ from what its file says; or read from a log of the
 * target. */
#ifndef SIM_HAL_COMMISSION_STAGE_RUN_H
#define SIM_HAL_COMMISSION_STAGE_RUN_H

#include <string>
#include <vector>

#include "../../firmware/recorder.h"
#include "../motion.h"
#include "standstill.h"

namespace berth
{

struct stage_run {
    std::vector<tick_record> ticks;
    std::vector<sensor_load> loads; /* of the ticks that brought a sample, in the sensor's axes */
    double load_step_s = 0.0;       /* between them */
    bool sent_setpoint = false;
    motion_evidence motion;
};

/* `told`: what firmware and log get; `hardware`: what is behind the wires. `log_path`: empty: none. */
stage_run play_stage(const rig &told, const rig &hardware, const std::string &log_path);

/* A log that the target wrote: its inputs are fed through the firmware again. Throws input_error where the log is
 * damaged, or was not made with `told`. */
stage_run read_stage(const std::string &log_path);

} // namespace berth

#endif
