/* A ULog file: header and topics once, then whatever the ring holds, in blocks with checksums (log_blocks.h). A disk
 * that is full or gone costs records, which are counted, never the run; the file always ends with a whole record.
 *
 * One thread may push while another drains: neither ever waits for the other. */
#ifndef HAL_LOG_FILE_H
#define HAL_LOG_FILE_H

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "log_ring.h"
#include "xxh64.h"

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

/* Of the second and each later file of one run: its number. */
constexpr const char *log_part_key = "berth_part";

/* The bytes that a ULog file starts with. */
std::string ulog_header(const log_header &header);

class log_file
{
  public:
    static constexpr std::size_t default_ring_bytes = std::size_t{1} << 18; /* stays in a second-level cache */

    /* An empty path: records are taken and forgotten. Throws input_error if the file cannot be made. */
    log_file(const std::string &path, const log_header &header, std::size_t ring_bytes = default_ring_bytes);
    ~log_file();
    log_file(const log_file &) = delete;
    log_file &operator=(const log_file &) = delete;

    /* Puts one record into the ring, whole or not at all. */
    bool push(const void *bytes, std::size_t size_bytes);

    /* Brings what the ring holds to the file, if it is half full. */
    void drain_if_due();

    /* Brings all of it to the file. */
    void drain();

    /* Ends the block and waits until the disk has what is in the file: a power cut cannot take it any more. */
    void sync();

    /* Ends the file, which the caller has renamed, and goes on in a new one. For the draining thread, after drain().
     * False: there is no new one with a whole header, and the earlier one goes on. */
    bool begin_part(const std::string &path, const log_header &header);

    std::int64_t file_bytes() const { return whole_bytes_; } /* for the draining thread */

    /* Shows the draining thread's caller every byte that comes out of the ring, before it goes to the file. */
    using witness = std::function<void(const std::uint8_t *bytes, std::size_t size_bytes)>;
    void show_to(witness shown) { witness_ = std::move(shown); }

    std::uint64_t dropped_records() const { return refused_records_.load() + unwritten_records_; }
    const char *trouble() const; /* what failed first, or empty */

  private:
    struct progress {
        std::uint64_t records; /* taken by the ring, ever */
        std::uint64_t refused_records;
        std::size_t ring_bytes; /* waiting, the last of these records included */
    };

    void begin_file(int file, const std::string &header_bytes);
    void sync_to_disk();
    void seal(bool is_last);
    void truncate();
    bool append(const void *bytes, std::size_t size_bytes);
    bool empty_ring(std::size_t size_bytes, bool is_written);
    progress pushed_so_far() const;

    std::vector<std::uint8_t> storage_;
    log_ring ring_;

    /* The pushing thread's. */
    std::atomic<std::uint64_t> begun_records_{0};
    std::atomic<std::uint64_t> pushed_records_{0};  /* refused ones included */
    std::atomic<std::uint64_t> refused_records_{0}; /* the ring was full */

    /* The draining thread's. */
    int file_ = -1;
    std::int64_t whole_bytes_ = 0; /* length of the file up to its last whole record */
    std::int64_t block_begin_ = 0; /* of the block that has not ended yet: the message that ended the one before */
    std::int64_t block_data_ = 0;  /* behind that message */
    xxh64 block_sum_;              /* of the block, up to whole_bytes_ */
    xxh64 written_sum_;            /* the same with what is being written */
    std::uint64_t drained_records_ = 0;
    std::uint64_t unwritten_records_ = 0; /* the file did not take them */
    std::uint64_t reported_drops_ = 0;
    int error_ = 0; /* errno of the first failed write */
    witness witness_;
};

} // namespace berth

#endif
