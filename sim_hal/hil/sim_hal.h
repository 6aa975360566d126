/* The simulated side of hal.h, opened from a rig in memory. Any number of them can live in one process. */
#ifndef SIM_HAL_HIL_SIM_HAL_H
#define SIM_HAL_HIL_SIM_HAL_H

#include <atomic>
#include <functional>
#include <optional>
#include <string>

#include "../../hal/hal.h"
#include "../../hal/log_file.h"
#include "virtual_rig.h"

namespace berth
{

struct sim_options {
    std::string log_path;                       /* ULog; empty: none */
    std::function<void(double share)> progress; /* called now and then with 0 to 1 */
    const std::atomic<bool> *stop = nullptr;    /* becomes true: an orderly stop is wanted */
    std::string robot = {};                     /* told in the log: the rig's robot preset; empty: none */
    std::optional<rig> told = {};               /* told in the log: the rig as its file has it, and the firmware */
};

/* Opens the simulated rig. Throws input_error. Close with hal_close(). */
struct hal *sim_open(const rig &rig, sim_options options = {});

/* What is behind the seam, for tests and reports. */
virtual_rig &sim_rig(struct hal *hal);
log_file &sim_log(struct hal *hal);
uint8_t sim_output(const struct hal *hal, hal_line line);

/* From now on the buses take no frame, as with a full transmit queue, or take them again. */
void sim_refuse_frames(struct hal *hal, bool refuses);

/* Presses the emergency stop or takes the enable away from the next tick on, whatever the rig's schedule says. */
void sim_set_input(struct hal *hal, hal_line line, uint8_t level);

} // namespace berth

#endif
