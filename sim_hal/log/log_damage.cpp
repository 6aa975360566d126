#include "log_damage.h"

#include <cstdint>
#include <cstdio>
#include <cstring>

#include "../../firmware/recorder.h"

namespace berth
{

namespace
{

enum class which_tick { first, last };

/* The time of a tick among the whole messages of [from_byte, to_byte). A log with checksums has berth's own ids. */
std::optional<double> time_of_tick_s(std::string_view file, std::uint64_t from_byte, std::uint64_t to_byte,
                                     which_tick which)
{
    std::optional<double> time_s;
    for (std::size_t at = from_byte; at + ulog_message_header_bytes <= to_byte;) {
        std::uint16_t size_bytes = 0;
        std::memcpy(&size_bytes, file.data() + at, sizeof size_bytes);
        const std::string_view content = file.substr(at + ulog_message_header_bytes, size_bytes);
        std::uint16_t id = 0;
        if (file[at + 2] == 'D' && content.size() == sizeof id + sizeof(tick_record)) {
            std::uint64_t time_us = 0;
            std::memcpy(&id, content.data(), sizeof id);
            std::memcpy(&time_us, content.data() + sizeof id, sizeof time_us);
            if (id == ULOG_TICK_ID) {
                time_s = 1e-6 * static_cast<double>(time_us);
            }
        }
        if (time_s && which == which_tick::first) {
            break;
        }
        at += ulog_message_header_bytes + size_bytes;
    }
    return time_s;
}

std::string time_text(const char *word, const std::optional<double> &time_s)
{
    char text[40] = "";
    if (time_s) {
        std::snprintf(text, sizeof text, "%s %.4f s", word, *time_s);
    }
    return text;
}

} // namespace

log_condition condition_of(std::string_view file, const log_check &check)
{
    log_condition condition;
    condition.has_checksums = check.has_blocks;
    if (!check.has_blocks) {
        return condition;
    }
    condition.is_cut = !check.is_ended && !check.damage;
    condition.whole_until_s = time_of_tick_s(file, ulog_file_header_bytes, check.readable_bytes, which_tick::last);
    if (check.damage) {
        condition.damage = {*check.damage, condition.whole_until_s,
                            time_of_tick_s(file, check.damage->to_byte, file.size(), which_tick::first)};
    }
    return condition;
}

std::string text_of(const log_damage &damage)
{
    const std::string times = time_text(", after", damage.last_whole_s) +
                              time_text(damage.last_whole_s ? " and before" : ", before", damage.whole_again_s);
    return "is damaged between byte " + std::to_string(damage.bytes.from_byte) + " and byte " +
           std::to_string(damage.bytes.to_byte) + times;
}

} // namespace berth
