#include "can_bus.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{
constexpr std::size_t initial_queue = 64; /* a power of two */
constexpr int error_frame_bits = 31;      /* flags up to 12, delimiter 8, interframe space 3, detection up to 8 */
} // namespace

can_bus::can_bus(const bus_rig &rig, hal_bus number, std::int64_t seed)
    : rig_(rig), number_(number), random_(seed, number == HAL_BUS_ROBOT ? stream_robot_bus : stream_sensor_bus),
      error_time_ns_(rig.ideal ? 0 : std::llround(1e9 * error_frame_bits / rig.bit_rate_bit_per_s)),
      queue_(initial_queue)
{
    for (int bytes = 0; bytes <= 8; bytes++) {
        frame_times_ns_[static_cast<std::size_t>(bytes)] = berth::frame_time_ns(rig, bytes);
    }
}

bool can_bus::is_lost()
{
    if (in_burst_) {
        in_burst_ = !random_.happens(1.0 / rig_.burst_length_frames);
        return true;
    }
    if (random_.happens(rig_.burst_probability)) {
        in_burst_ = !random_.happens(1.0 / rig_.burst_length_frames);
        return true;
    }
    return random_.happens(rig_.loss_probability);
}

bool can_bus::transmit(const hal_frame &frame, std::int64_t ready_ns, std::int64_t *end_ns)
{
    const std::int64_t frame_ns = frame_times_ns_[std::min<std::size_t>(frame.length, 8)];
    std::int64_t end = std::max(ready_ns, free_at_ns_) + frame_ns;
    while (random_.happens(rig_.error_probability)) {
        const hal_frame report{end, 0, static_cast<std::uint8_t>(number_), 8, HAL_FRAME_ERROR, 0, {}};
        queue(report, end);
        end += error_time_ns_ + frame_ns;
    }
    free_at_ns_ = end;
    *end_ns = end;
    return !is_lost();
}

void can_bus::transmit_to_loop(const hal_frame &frame, std::int64_t ready_ns)
{
    std::int64_t end_ns = 0;
    if (transmit(frame, ready_ns, &end_ns)) {
        queue(frame, end_ns);
    }
}

void can_bus::queue(const hal_frame &frame, std::int64_t arrival_ns)
{
    if (count_ == queue_.size()) {
        std::vector<hal_frame> larger(2 * queue_.size());
        for (std::size_t i = 0; i < count_; i++) {
            larger[i] = queue_[(first_ + i) & (queue_.size() - 1)];
        }
        queue_.swap(larger);
        first_ = 0;
    }
    std::size_t place = count_++;
    const std::size_t mask = queue_.size() - 1;
    while (place > 0 && queue_[(first_ + place - 1) & mask].time_ns > arrival_ns) {
        queue_[(first_ + place) & mask] = queue_[(first_ + place - 1) & mask];
        place--;
    }
    hal_frame &queued = queue_[(first_ + place) & mask];
    queued = frame;
    queued.time_ns = arrival_ns;
}

bool can_bus::receive(std::int64_t now_ns, hal_frame &frame)
{
    if (count_ == 0 || queue_[first_].time_ns > now_ns) {
        return false;
    }
    frame = queue_[first_];
    first_ = (first_ + 1) & (queue_.size() - 1);
    count_--;
    return true;
}

} // namespace berth
