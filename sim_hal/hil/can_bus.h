/* One classic CAN bus in virtual time: frames are sent one after another, take their bit time, get lost one by
 * one or in bursts, or are destroyed by an error and sent again. */
#ifndef SIM_HAL_HIL_CAN_BUS_H
#define SIM_HAL_HIL_CAN_BUS_H

#include <array>
#include <cstdint>
#include <vector>

#include "../../hal/hal.h"
#include "../../hal/rig/rig.h"
#include "random.h"

namespace berth
{

class can_bus
{
  public:
    can_bus(const bus_rig &rig, hal_bus number, std::int64_t seed);

    /* Puts a frame on the bus that is ready at `ready_ns`. True if it gets through; *end_ns is the end of frame. */
    bool transmit(const hal_frame &frame, std::int64_t ready_ns, std::int64_t *end_ns);

    /* The same for a frame to the loop: it is queued until the loop takes it. */
    void transmit_to_loop(const hal_frame &frame, std::int64_t ready_ns);

    /* The oldest frame that has arrived by `now_ns`. */
    bool receive(std::int64_t now_ns, hal_frame &frame);

    /* When the oldest frame that the loop has not taken arrives. */
    std::int64_t next_arrival_ns() const { return count_ == 0 ? INT64_MAX : queue_[first_].time_ns; }

    std::int64_t frame_time_ns(int data_bytes) const
    {
        return frame_times_ns_[static_cast<std::size_t>(data_bytes)];
    }

  private:
    bool is_lost();
    void queue(const hal_frame &frame, std::int64_t arrival_ns);

    bus_rig rig_;
    hal_bus number_;
    random_stream random_;
    std::array<std::int64_t, 9> frame_times_ns_;
    std::int64_t error_time_ns_;
    std::int64_t free_at_ns_ = 0;
    bool in_burst_ = false;
    std::vector<hal_frame> queue_; /* ring, in order of arrival */
    std::size_t first_ = 0;
    std::size_t count_ = 0;
};

} // namespace berth

#endif
