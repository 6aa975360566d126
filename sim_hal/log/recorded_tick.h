/* The ticks of a log, one after the other, with the inputs that the firmware had in them. */
#ifndef SIM_HAL_LOG_RECORDED_TICK_H
#define SIM_HAL_LOG_RECORDED_TICK_H

#include <vector>

#include "../../firmware/app.h"
#include "ulog_reader.h"

namespace berth
{

/* One tick as recorded: frames, arm and further axes come before the tick that they belong to. */
struct recorded_tick {
    tick_record record;
    arm_record arm;
    side_record side;
    std::vector<frame_record> sent;
    tick_input in;
};

/* The next one. False at the end. */
bool read_tick(ulog_reader &log, recorded_tick &tick);

} // namespace berth

#endif
