/* State of a CAN interface, asked of the kernel by rtnetlink: what `ip -details link` shows. */
#ifndef HAL_LINUX_CAN_LINK_H
#define HAL_LINUX_CAN_LINK_H

#include <cstdint>
#include <optional>
#include <string>

namespace berth
{

struct can_link {
    bool is_can = false;
    bool is_up = false;
    bool is_virtual = false; /* vcan: no controller, no bit rate */
    std::uint32_t transmit_queue_frames = 0;
    std::uint32_t bit_rate_bit_per_s = 0;
    std::uint32_t restart_ms = 0; /* 0: stays off the bus after bus-off */
    std::string state;            /* "error-active", "bus-off"; empty where there is no controller */
};

/* The driver stamps every received frame with the controller's own clock. */
bool has_hardware_stamps(const std::string &interface);

/* Nothing: there is no such interface. */
std::optional<can_link> find_can_link(const std::string &interface);

} // namespace berth

#endif
