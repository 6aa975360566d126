#include "ulog_reader.h"

#include <algorithm>
#include <set>

#include "../../hal/log_blocks.h"
#include "../../hal/rig/given.h"
#include "../../hal/rig/rig_file.h"
#include "../hil/rig_record.h"

namespace berth
{

namespace
{

/* Of the format: log_file writes the first six; those after them (several infos, parameters and their defaults,
 * texts, sync marks, ends of subscriptions) are passed over. */
constexpr std::string_view known_messages = "BFIADOMPQLCSR";
constexpr std::size_t can_data_bytes_max = 8;

/* Of logs from before motors at their torque limits were told: the same bytes, with 0 in their place. */
std::string arm_format_without_motors()
{
    const std::string now = "uint16_t guided_by;uint16_t motors_at_limit;";
    std::string format = arm_record_format;
    return format.replace(format.find(now), now.size(), "uint32_t guided_by;");
}

struct known_topic {
    std::string_view name;
    std::uint16_t id;
    std::size_t bytes;
};
constexpr known_topic known_topics[] = {{"tick", ULOG_TICK_ID, sizeof(tick_record)},
                                        {"can_frame", ULOG_FRAME_ID, sizeof(frame_record)},
                                        {"arm", ULOG_ARM_ID, sizeof(arm_record)},
                                        {"side", ULOG_SIDE_ID, sizeof(side_record)},
                                        {"rig", ulog_rig_id, sizeof(rig_values)}};

const known_topic *topic_of(std::uint16_t id)
{
    const auto found = std::find_if(std::begin(known_topics), std::end(known_topics),
                                    [&](const known_topic &known) { return known.id == id; });
    return found == std::end(known_topics) ? nullptr : found;
}

/* All records begin with it. */
std::uint64_t timestamp_of(std::string_view record)
{
    return record_as<std::uint64_t>(record);
}

/* Fit for a terminal. */
std::string printable_name(std::string_view text)
{
    constexpr std::size_t longest = 40;
    std::string result(text.substr(0, longest));
    std::replace_if(
        result.begin(), result.end(), [](unsigned char c) { return c < 0x20 || c >= 0x7f; }, '?');
    return result;
}

} // namespace

ulog_reader::ulog_reader(const std::string &path) : path_(path)
{
    bytes_ = read_file(path);
    whole_bytes_ = bytes_.size();
    if (bytes_.size() < ulog_file_header_bytes || bytes_.compare(0, 7, "ULog\x01\x12\x35") != 0) {
        throw input_error(path + ": is not a ULog file; `berth run` writes them, their names end in .ulg");
    }
    check_whole();
    read_header();
}

/* Leaves of the file what can be read. */
void ulog_reader::check_whole()
{
    const log_check check = check_blocks(bytes_);
    condition_ = condition_of(bytes_, check);
    if (check.has_blocks) {
        whole_bytes_ = check.readable_bytes;
    }
    if (condition_.damage && whole_bytes_ == 0) {
        throw input_error(path_ + ": is damaged in its header, before byte " +
                          std::to_string(condition_.damage->bytes.to_byte) + ": without it no record can be read");
    }
}

void ulog_reader::fail_damaged(std::size_t at_byte) const
{
    throw input_error(path_ + ": is damaged at byte " + std::to_string(at_byte));
}

bool ulog_reader::next_message(char &type, std::string_view &content)
{
    std::uint16_t size = 0;
    const std::size_t left = whole_bytes_ - at_;
    if (left >= ulog_message_header_bytes) {
        std::memcpy(&size, bytes_.data() + at_, sizeof size);
    }
    if (left < ulog_message_header_bytes + size) {
        condition_.is_cut = condition_.is_cut || left > 0;
        return false;
    }
    type = bytes_[at_ + 2];
    if (known_messages.find(type) == std::string_view::npos) {
        fail_damaged(at_);
    }
    content = std::string_view(bytes_).substr(at_ + ulog_message_header_bytes, size);
    at_ += ulog_message_header_bytes + size;
    return true;
}

void ulog_reader::take_info(std::string_view content, std::size_t at_byte)
{
    const std::size_t key_size = content.empty() ? 0 : static_cast<unsigned char>(content[0]);
    if (content.size() < 1 + key_size) {
        fail_damaged(at_byte);
    }
    const std::string_view typed_key = content.substr(1, key_size);
    const std::string text_type = "char[" + std::to_string(content.size() - 1 - key_size) + "]";
    if (typed_key.substr(0, 5) == "char[" && typed_key.substr(0, typed_key.find(' ')) != text_type) {
        fail_damaged(at_byte);
    }
    infos_[std::string(typed_key.substr(typed_key.find(' ') + 1))] = content.substr(1 + key_size);
}

/* A subscription gives a topic its message id in this file. */
void ulog_reader::take_subscription(std::string_view content, std::size_t at_byte)
{
    constexpr std::size_t name_at = 3; /* behind the number of the instance and the message id */
    if (content.size() < name_at) {
        fail_damaged(at_byte);
    }
    std::uint16_t id = 0;
    std::memcpy(&id, content.data() + 1, sizeof id);
    const std::string_view name = content.substr(name_at);
    topics_[id] = name;
    for (const known_topic &known : known_topics) {
        if (known.name == name) {
            ids_[id] = known.id;
        }
    }
}

/* Reads on to the end: a program may subscribe to topics at any time. */
void ulog_reader::refuse_other_program()
{
    if (infos_.count("sys_name") == 0 && topics_.empty()) {
        throw input_error(path_ +
                          ": carries no configuration; is it a log of this program, and not cut in its header?");
    }
    if (infos_.count("sys_name") != 0 && infos_["sys_name"] == "berth") {
        throw input_error(path_ + ": carries no configuration; was it cut in its header?");
    }
    char type = 0;
    std::string_view content;
    for (std::size_t before = at_; next_message(type, content); before = at_) {
        if (type == 'A') {
            take_subscription(content, before);
        }
    }
    constexpr std::size_t named_max = 8;
    std::set<std::string> names;
    for (const auto &[id, name] : topics_) {
        names.insert(printable_name(name));
    }
    std::string told;
    std::size_t count = 0;
    for (const std::string &name : names) {
        if (count++ < named_max) {
            told += (told.empty() ? "" : ", ") + name;
        }
    }
    const std::string further = count > named_max ? " and " + std::to_string(count - named_max) + " more" : "";
    const std::string of = infos_.count("sys_name") == 0 ? "a log of another program"
                                                         : "a " + printable_name(infos_["sys_name"]) + " log";
    throw input_error(path_ + ": is " + of + ": no berth topics; " +
                      (names.empty() ? "there are none inside" : "these are inside: " + told + further) +
                      "; a record of another program is read as a CSV file");
}

void ulog_reader::read_header()
{
    at_ = ulog_file_header_bytes;
    char type = 0;
    std::string_view content;
    std::set<std::string_view> formats;
    for (std::size_t before = at_; next_message(type, content); before = at_) {
        if (type == 'F') {
            formats.insert(content);
        } else if (type == 'I') {
            take_info(content, before);
        } else if (type == 'A') {
            take_subscription(content, before);
        } else if (type == 'D' || type == 'O') {
            at_ = before;
            break;
        }
    }
    if (infos_.count("berth_config") == 0) {
        refuse_other_program();
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

bool ulog_reader::next_data(data_message &data)
{
    if (ahead_) {
        data = *ahead_;
        ahead_.reset();
        return true;
    }
    char type = 0;
    std::string_view content;
    while (next_message(type, content)) {
        const std::size_t at_byte = at_ - content.size() - ulog_message_header_bytes;
        has_dropouts_ = has_dropouts_ || type == 'O';
        if (type == 'A') {
            take_subscription(content, at_byte);
        }
        if (type != 'D' || content.size() < sizeof data.id) {
            continue;
        }
        std::memcpy(&data.id, content.data(), sizeof data.id);
        data.record = content.substr(sizeof data.id);
        const auto ours = ids_.find(data.id);
        if (ours == ids_.end()) {
            data.id = other_topic_id;
            return true;
        }
        data.id = ours->second;
        if (data.record.size() != topic_of(data.id)->bytes ||
            (data.id == ULOG_FRAME_ID && record_as<frame_record>(data.record).length > can_data_bytes_max)) {
            fail_damaged(at_byte);
        }
        return true;
    }
    return false;
}

/* A tick comes behind all else of its time: programs that sort by topic put it first. */
bool ulog_reader::next(std::uint16_t &id, std::string_view &record)
{
    data_message data{};
    while (next_data(data)) {
        const bool is_of_tick = tick_ && data.id != ULOG_TICK_ID && data.record.size() >= sizeof(std::uint64_t) &&
                                timestamp_of(data.record) == timestamp_of(tick_->record);
        if (tick_ && !is_of_tick) {
            ahead_ = data;
            data = *tick_;
            tick_.reset();
        } else if (data.id == ULOG_TICK_ID) {
            tick_ = data;
            continue;
        }
        id = data.id;
        record = data.record;
        return true;
    }
    if (tick_) {
        id = tick_->id;
        record = tick_->record;
        tick_.reset();
        return true;
    }
    if (condition_.damage && !stops_at_damage_) {
        throw input_error(path_ + ": " + text_of(*condition_.damage));
    }
    return false;
}

rig ulog_reader::recorded_rig() const
{
    rig rig = parse_rig(infos_.at("berth_config"), path_ + " (recorded configuration)");
    if (const auto assumed = infos_.find("berth_assumed"); assumed != infos_.end()) {
        if (!set_assumed(rig, assumed->second)) {
            throw input_error(path_ + ": is damaged: berth_assumed names a key that there is not");
        }
    }
    return rig;
}

hal_frame frame_of(const frame_record &record)
{
    hal_frame frame{record.time_ns, record.id, record.bus, record.length, record.flags, 0, {}};
    std::memcpy(frame.data, &record.data, sizeof frame.data);
    return frame;
}

} // namespace berth
