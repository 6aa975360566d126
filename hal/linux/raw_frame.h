/* A frame of the loop as SocketCAN sends it. */
#ifndef HAL_LINUX_RAW_FRAME_H
#define HAL_LINUX_RAW_FRAME_H

#include <linux/can.h>

#include <cstring>

#include "../hal.h"

namespace berth
{

inline can_frame raw_frame(const hal_frame &frame)
{
    can_frame raw{};
    raw.can_id = frame.id | ((frame.flags & HAL_FRAME_REMOTE) ? CAN_RTR_FLAG : 0u);
    raw.can_dlc = frame.length;
    std::memcpy(raw.data, frame.data, sizeof raw.data);
    return raw;
}

} // namespace berth

#endif
