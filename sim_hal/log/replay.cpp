#include "replay.h"

#include <array>
#include <charconv>
#include <memory>
#include <vector>

#include "../../firmware/app.h"
#include "../../hal/log_file.h"
#include "../../hal/rig/rig_file.h"
#include "recorded_tick.h"

namespace berth
{

namespace
{

template <typename T>
std::string text_of(T value)
{
    char text[40];
    const auto [end, error] = std::to_chars(text, text + sizeof text, value);
    return std::string(text, end);
}

/* Every bit counts: two NaN can be equal, 0 and -0 are not. */
template <typename T>
std::array<unsigned char, sizeof(T)> bits_of(const T &value)
{
    std::array<unsigned char, sizeof(T)> bits;
    std::memcpy(bits.data(), &value, sizeof value);
    return bits;
}

/* Sets the first difference, if there is none yet. */
template <typename T>
void compare(replay_result &result, const std::string &field, const T &recorded, const T &replayed)
{
    if (result.is_equal && bits_of(recorded) != bits_of(replayed)) {
        result.is_equal = false;
        result.field = field;
        result.recorded = text_of(recorded);
        result.replayed = text_of(replayed);
    }
}

void compare_ticks(replay_result &result, const tick_record &recorded, const tick_record &replayed)
{
#define COMPARE_FIELD(type, name) compare(result, #name, recorded.name, replayed.name);
    TICK_RECORD_FIELDS(COMPARE_FIELD)
}

void compare_frames(replay_result &result, const std::vector<frame_record> &recorded, const tick_output &replayed)
{
    compare(result, "frames sent", static_cast<std::uint32_t>(recorded.size()), replayed.frame_count);
    for (std::size_t i = 0; result.is_equal && i < recorded.size(); i++) {
        const hal_frame &frame = replayed.frames[i];
        const std::string name = "sent frame " + std::to_string(i) + " ";
        std::uint64_t data = 0;
        std::memcpy(&data, frame.data, sizeof data);
        compare(result, name + "id", recorded[i].id, frame.id);
        compare(result, name + "length", recorded[i].length, frame.length);
        compare(result, name + "data", recorded[i].data, data);
    }
}

void compare_arms(replay_result &result, const arm_record &recorded, const arm_record &replayed)
{
#define COMPARE_ARM_FIELD(type, name) compare(result, "arm " #name, recorded.name, replayed.name);
    ARM_RECORD_FIELDS(COMPARE_ARM_FIELD)
}

void compare_sides(replay_result &result, const side_record &recorded, const side_record &replayed)
{
#define COMPARE_SIDE_FIELD(type, name) compare(result, "side " #name, recorded.name, replayed.name);
    SIDE_RECORD_FIELDS(COMPARE_SIDE_FIELD)
}

} // namespace

replay_result replay_log(const std::string &path)
{
    ulog_reader log(path);
    log.stop_at_damage();
    if (const auto part = log.infos().find(log_part_key); part != log.infos().end()) {
        throw input_error(
            path + ": is part " + part->second +
            " of a run: the state in which it begins is not in it; replay the first part, which is the "
            "file of the run with the smallest number");
    }
    const rig rig = log.recorded_rig();
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &rig.firmware);

    replay_result result;
    recorded_tick tick{};
    std::int64_t next_index = 0;
    while (result.is_equal && read_tick(log, tick)) {
        if (tick.record.index - tick.record.missed_ticks != next_index) {
            result.has_gap = true;
            break;
        }
        next_index = tick.record.index + 1;
        tick_output out;
        app_step(app.get(), &tick.in, &out);
        result.tick = tick.record.index;
        compare_ticks(result, tick.record, app->recorder.tick);
        compare_arms(result, tick.arm, app->arm_record);
        if (app->side_axes.any) {
            compare_sides(result, tick.side, app->side_record);
        }
        compare_frames(result, tick.sent, out);
        result.ticks += result.is_equal;
    }
    result.condition = log.condition();
    return result;
}

} // namespace berth
