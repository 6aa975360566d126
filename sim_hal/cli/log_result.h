/* What a log tells of its run, as the run told it. */
#ifndef SIM_HAL_CLI_LOG_RESULT_H
#define SIM_HAL_CLI_LOG_RESULT_H

#include "run_result.h"

namespace berth
{

/* What a log tells beside the run's result. */
struct log_state {
    bool is_cut = false;
    std::int64_t missing_ticks = 0; /* not in the log, though the loop ran them */
};

/* Fills in the rig that the log was made with. Throws input_error. */
run_result read_result(const std::string &path, rig &rig, log_state &state);

} // namespace berth

#endif
