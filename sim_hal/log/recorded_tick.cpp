#include "recorded_tick.h"

namespace berth
{

bool read_tick(ulog_reader &log, recorded_tick &tick)
{
    std::uint16_t id = 0;
    std::string_view bytes;
    tick.sent.clear();
    tick.in.frame_count = 0;
    while (log.next(id, bytes)) {
        if (id == ULOG_FRAME_ID) {
            const auto frame = record_as<frame_record>(bytes);
            if (frame.direction != 0) {
                tick.sent.push_back(frame);
            } else if (tick.in.frame_count < TICK_FRAMES_IN_MAX) {
                tick.in.frames[tick.in.frame_count++] = frame_of(frame);
            }
        } else if (id == ULOG_ARM_ID) {
            tick.arm = record_as<arm_record>(bytes);
        } else if (id == ULOG_SIDE_ID) {
            tick.side = record_as<side_record>(bytes);
        } else if (id == ULOG_TICK_ID) {
            tick.record = record_as<tick_record>(bytes);
            const tick_record &record = tick.record;
            tick.in.tick = {record.index, record.scheduled_ns, record.woke_ns, record.missed_ticks, record.stop};
            tick.in.unsent_frames = record.unsent_frames;
            tick.in.enable = record.enable;
            tick.in.emergency_stop = record.emergency_stop;
            return true;
        }
    }
    return false;
}

} // namespace berth
