#include "ulog_reader.h"

#include <algorithm>
#include <set>

#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

constexpr std::size_t file_header_bytes = 16;
constexpr std::size_t message_header_bytes = 3;
constexpr std::string_view known_messages = "BFIADO"; /* those that log_file writes */
constexpr std::size_t can_data_bytes_max = 8;

/* Of logs from before motors at their torque limits were told: the same bytes, with 0 in their place. */
std::string arm_format_without_motors()
{
    const std::string now = "uint16_t guided_by;uint16_t motors_at_limit;";
    std::string format = arm_record_format;
    return format.replace(format.find(now), now.size(), "uint32_t guided_by;");
}

} // namespace

ulog_reader::ulog_reader(const std::string &path) : path_(path)
{
    bytes_ = read_file(path);
    if (bytes_.size() < file_header_bytes || bytes_.compare(0, 7, "ULog\x01\x12\x35") != 0) {
        throw input_error(path + ": is not a ULog file");
    }
    read_header();
}

void ulog_reader::fail_damaged(std::size_t at_byte) const
{
    throw input_error(path_ + ": is damaged at byte " + std::to_string(at_byte));
}

bool ulog_reader::next_message(char &type, std::string_view &content)
{
    std::uint16_t size = 0;
    const std::size_t left = bytes_.size() - at_;
    if (left >= message_header_bytes) {
        std::memcpy(&size, bytes_.data() + at_, sizeof size);
    }
    if (left < message_header_bytes + size) {
        is_cut_ = is_cut_ || left > 0;
        return false;
    }
    type = bytes_[at_ + 2];
    if (known_messages.find(type) == std::string_view::npos) {
        fail_damaged(at_);
    }
    content = std::string_view(bytes_).substr(at_ + message_header_bytes, size);
    at_ += message_header_bytes + size;
    return true;
}

void ulog_reader::read_header()
{
    at_ = file_header_bytes;
    char type = 0;
    std::string_view content;
    std::set<std::string_view> formats;
    for (std::size_t before = at_; next_message(type, content); before = at_) {
        if (type == 'F') {
            formats.insert(content);
        } else if (type == 'I') {
            const std::size_t key_size = content.empty() ? 0 : static_cast<unsigned char>(content[0]);
            if (content.size() < 1 + key_size) {
                fail_damaged(before);
            }
            const std::string_view typed_key = content.substr(1, key_size);
            infos_[std::string(typed_key.substr(typed_key.find(' ') + 1))] = content.substr(1 + key_size);
        } else if (type == 'D' || type == 'O') {
            at_ = before;
            break;
        }
    }
    if (infos_.count("berth_config") == 0) {
        throw input_error(path_ +
                          ": carries no configuration; is it a log of this program, and not cut in its header?");
    }
    const std::string without_motors = arm_format_without_motors();
    knows_motors_ = formats.count(without_motors) == 0;
    const bool has_other_arm = std::any_of(formats.begin(), formats.end(), [&](std::string_view format) {
        return format.substr(0, 4) == "arm:" && format != arm_record_format && format != without_motors;
    });
    if (formats.count(tick_record_format) + formats.count(frame_record_format) < 2 || has_other_arm) {
        throw input_error(path_ + ": its records have other fields than this program's; it was written by another "
                                  "version, or is damaged");
    }
    if (text_hash(infos_["berth_config"]) != infos_["berth_config_hash"]) {
        throw input_error(path_ + ": is damaged: the recorded configuration does not have the recorded hash");
    }
}

bool ulog_reader::next(std::uint16_t &id, std::string_view &record)
{
    char type = 0;
    std::string_view content;
    while (next_message(type, content)) {
        has_dropouts_ = has_dropouts_ || type == 'O';
        if (type != 'D' || content.size() < sizeof id) {
            continue;
        }
        std::memcpy(&id, content.data(), sizeof id);
        record = content.substr(sizeof id);
        const std::size_t expected = id == ULOG_TICK_ID    ? sizeof(tick_record)
                                     : id == ULOG_FRAME_ID ? sizeof(frame_record)
                                     : id == ULOG_ARM_ID   ? sizeof(arm_record)
                                     : id == ULOG_SIDE_ID  ? sizeof(side_record)
                                                           : record.size();
        if (record.size() != expected ||
            (id == ULOG_FRAME_ID && record_as<frame_record>(record).length > can_data_bytes_max)) {
            fail_damaged(at_ - content.size() - message_header_bytes);
        }
        return true;
    }
    return false;
}

rig ulog_reader::recorded_rig() const
{
    return parse_rig(infos_.at("berth_config"), path_ + " (recorded configuration)");
}

hal_frame frame_of(const frame_record &record)
{
    hal_frame frame{record.time_ns, record.id, record.bus, record.length, record.flags, 0, {}};
    std::memcpy(frame.data, &record.data, sizeof frame.data);
    return frame;
}

} // namespace berth
