/* The simulated rig's own topic in the log: what was really so at each tick. */
#ifndef SIM_HAL_HIL_RIG_RECORD_H
#define SIM_HAL_HIL_RIG_RECORD_H

#include <cstdint>

#include "../../firmware/recorder.h"

namespace berth
{

#define RIG_RECORD_FIELDS(X)                                                                                        \
    X(uint64_t, timestamp)                                                                                          \
    X(double, robot_position_m)                                                                                     \
    X(double, robot_velocity_m_per_s)                                                                               \
    X(double, object_position_m)                                                                                    \
    X(double, object_velocity_m_per_s)                                                                              \
    X(double, spring_force_N)                                                                                       \
    X(double, measured_force_N)

/* A record by itself, as a log is read. */
struct rig_values {
    RIG_RECORD_FIELDS(RECORD_MEMBER)
};

#pragma pack(push, 1)
struct rig_message {
    std::uint16_t size_bytes;
    char type;
    std::uint16_t id;
    RIG_RECORD_FIELDS(RECORD_MEMBER)
};
#pragma pack(pop)

constexpr std::uint16_t ulog_rig_id = 2;

} // namespace berth

#endif
