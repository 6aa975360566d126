/* Reads what log_file writes, also if the file was cut anywhere: all whole messages before the cut; if it is
 * damaged, up to the last block before that whose checksum fits; and also as other programs save it again, with
 * other message ids and the records of one time in another order. */
#ifndef SIM_HAL_LOG_ULOG_READER_H
#define SIM_HAL_LOG_ULOG_READER_H

#include <cstdint>
#include <cstring>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "../../firmware/recorder.h"
#include "../../hal/rig/rig.h"
#include "log_damage.h"

namespace berth
{

class ulog_reader
{
  public:
    /* Reads the whole file and its header. Throws input_error if it is no log of this program. */
    explicit ulog_reader(const std::string &path);

    /* The next data message: its id, as in recorder.h or other_topic_id, and bytes. False at the end. At a damage it
     * throws input_error, or, after this, ends. */
    void stop_at_damage() { stops_at_damage_ = true; }
    static constexpr std::uint16_t other_topic_id = 0xffff;
    bool next(std::uint16_t &id, std::string_view &record);

    /* Of the file. */
    std::string_view bytes() const { return bytes_; }

    const std::map<std::string, std::string> &infos() const { return infos_; }

    /* The configuration that the log was made with. Throws input_error. */
    rig recorded_rig() const;

    /* Its arm records, if any, tell of motors at their torque limits; else they have 0 there. */
    bool knows_motors() const { return knows_motors_; }

    /* Whether a file without checksums is cut is known when all of it has been read. */
    const log_condition &condition() const { return condition_; }

    /* Records were dropped while this log was written. */
    bool has_dropouts() const { return has_dropouts_; }

  private:
    struct data_message {
        std::uint16_t id;
        std::string_view record;
    };
    bool next_message(char &type, std::string_view &content);
    bool next_data(data_message &data);
    void read_header();
    void take_info(std::string_view content, std::size_t at_byte);
    void take_subscription(std::string_view content, std::size_t at_byte);
    [[noreturn]] void refuse_other_program();
    [[noreturn]] void fail_damaged(std::size_t at_byte) const;
    void check_whole();

    std::string path_;
    std::string bytes_;
    std::size_t whole_bytes_ = 0;
    std::size_t at_ = 0;
    std::map<std::string, std::string> infos_;
    std::map<std::uint16_t, std::string> topics_;
    std::map<std::uint16_t, std::uint16_t> ids_; /* those of the file to ours */
    std::optional<data_message> tick_;           /* waits for what belongs to it */
    std::optional<data_message> ahead_;
    bool knows_motors_ = true;
    log_condition condition_;
    bool stops_at_damage_ = false;
    bool has_dropouts_ = false;
};

/* A record by value. The sizes must match. */
template <typename T>
T record_as(std::string_view record)
{
    T value;
    std::memcpy(&value, record.data(), sizeof value);
    return value;
}

/* The frame that a record describes. */
hal_frame frame_of(const frame_record &record);

} // namespace berth

#endif
