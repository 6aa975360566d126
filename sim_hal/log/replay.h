/* Feeds the recorded inputs of a log through the firmware again: the outputs must come out the same, bit for bit. */
#ifndef SIM_HAL_LOG_REPLAY_H
#define SIM_HAL_LOG_REPLAY_H

#include <cstdint>
#include <string>

#include "log_damage.h"

namespace berth
{

struct replay_result {
    std::int64_t ticks = 0; /* replayed and equal */
    bool is_equal = true;
    bool has_gap = false;    /* records are missing: replayed up to there */
    log_condition condition; /* of the file: replayed up to a cut or damage */
    /* The first difference: */
    std::int64_t tick = 0;
    std::string field;
    std::string recorded;
    std::string replayed;
};

/* Throws input_error. */
replay_result replay_log(const std::string &path);

} // namespace berth

#endif
