/* A ULog file: header and topics once, then whatever the ring holds. A disk that is full or gone costs records,
 * which are counted, never the run; the file always ends with a whole record. */
#ifndef HAL_LOG_FILE_H
#define HAL_LOG_FILE_H

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "log_ring.h"

namespace berth
{

struct log_topic {
    std::uint16_t id;
    std::string name;
    std::string format; /* "name:type field;..." */
};

struct log_header {
    std::vector<std::pair<std::string, std::string>> infos; /* key, text */
    std::vector<log_topic> topics;
};

/* The bytes that a ULog file starts with. */
std::string ulog_header(const log_header &header);

class log_file
{
  public:
    /* An empty path: records are taken and forgotten. Makes the folder. Throws input_error if the file cannot be
     * made. */
    log_file(const std::string &path, const log_header &header);
    ~log_file();
    log_file(const log_file &) = delete;
    log_file &operator=(const log_file &) = delete;

    /* Puts one record into the ring, whole or not at all. */
    bool push(const void *bytes, std::size_t size_bytes);

    /* Brings what the ring holds to the file, if it is half full. */
    void drain_if_due();

    /* Brings all of it to the file. */
    void drain();

    std::uint64_t dropped_records() const { return dropped_records_; }
    const std::string &trouble() const { return trouble_; } /* what failed first, or empty */

  private:
    bool write_all(const std::uint8_t *bytes, std::size_t size_bytes);
    void drop_ring();

    std::vector<std::uint8_t> storage_;
    log_ring ring_;
    int file_ = -1;
    std::int64_t whole_bytes_ = 0; /* length of the file up to its last whole record */
    std::uint64_t records_in_ring_ = 0;
    std::uint64_t dropped_records_ = 0;
    std::uint64_t reported_drops_ = 0;
    std::string trouble_;
};

} // namespace berth

#endif
