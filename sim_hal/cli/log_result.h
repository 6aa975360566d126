/* What a log tells of its run, as the run told it. */
#ifndef SIM_HAL_CLI_LOG_RESULT_H
#define SIM_HAL_CLI_LOG_RESULT_H

#include "../log/log_damage.h"
#include "run_result.h"

namespace berth
{

/* What a log tells beside the run's result. */
struct log_state {
    log_condition condition; /* read up to a cut or damage */
    std::int64_t ticks = 0;
    std::int64_t missing_ticks = 0; /* not in the log, though the loop ran them */
};

/* Fills in the rig that the log was made with. Throws input_error. */
run_result read_result(const std::string &path, rig &rig, log_state &state);

} // namespace berth

#endif
