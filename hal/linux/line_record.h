/* The target's own topic in the log: edges of the emergency stop, with the kernel's stamp. */
#ifndef HAL_LINUX_LINE_RECORD_H
#define HAL_LINUX_LINE_RECORD_H

#include <cstdint>

#include "../../firmware/recorder.h"

namespace berth
{

#define LINE_RECORD_FIELDS(X)                                                                                       \
    X(uint64_t, timestamp)                                                                                          \
    X(int64_t, time_ns)                                                                                             \
    X(uint8_t, line)                                                                                                \
    X(uint8_t, level)

#pragma pack(push, 1)
struct line_message {
    std::uint16_t size_bytes;
    char type;
    std::uint16_t id;
    LINE_RECORD_FIELDS(RECORD_MEMBER)
};
#pragma pack(pop)

constexpr std::uint16_t ulog_line_id = 3;

} // namespace berth

#endif
