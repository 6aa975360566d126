#include "log_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "log_blocks.h"
#include "rig/rig_file.h"

namespace berth
{

namespace
{

/* Long against the message that ends a block, short against a log. */
constexpr std::int64_t block_bytes_min = 1 << 16;

/* The owner writes, the group reads: a log shows what a rig does. */
constexpr mode_t log_mode = 0640;

/* Of a counter that one thread alone changes: no locked instruction. */
void count(std::atomic<std::uint64_t> &counter)
{
    counter.store(counter.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

void append_message(std::string &bytes, char type, const std::string &content)
{
    const auto size = static_cast<std::uint16_t>(content.size());
    bytes.append(reinterpret_cast<const char *>(&size), sizeof size);
    bytes += type;
    bytes += content;
}

std::string info(const std::string &key, const std::string &text)
{
    const std::string typed_key = "char[" + std::to_string(text.size()) + "] " + key;
    return std::string(1, static_cast<char>(typed_key.size())) + typed_key + text;
}

int open_log(const std::string &path)
{
    return open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, log_mode);
}

/* 0, or errno. */
int write_all(int file, const char *bytes, std::size_t size_bytes)
{
    while (size_bytes > 0) {
        const ssize_t written = write(file, bytes, size_bytes);
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written <= 0) {
            return written < 0 ? errno : ENOSPC;
        }
        bytes += written;
        size_bytes -= static_cast<std::size_t>(written);
    }
    return 0;
}

std::string subscription(const log_topic &topic)
{
    std::string content(1, '\0'); /* multi id */
    content.append(reinterpret_cast<const char *>(&topic.id), sizeof topic.id);
    return content + topic.name;
}

} // namespace

std::string ulog_header(const log_header &header)
{
    std::string bytes("ULog\x01\x12\x35\x01", 8);
    bytes.append(8, '\0'); /* the log starts at 0 us */
    append_message(bytes, 'B', std::string(40, '\0'));
    for (const log_topic &topic : header.topics) {
        append_message(bytes, 'F', topic.format);
    }
    for (const auto &[key, text] : header.infos) {
        append_message(bytes, 'I', info(key, text));
    }
    for (const log_topic &topic : header.topics) {
        append_message(bytes, 'A', subscription(topic));
    }
    return bytes;
}

log_file::log_file(const std::string &path, const log_header &header, std::size_t ring_bytes) : storage_(ring_bytes)
{
    log_ring_start(&ring_, storage_.data(), storage_.size());
    if (path.empty()) {
        return;
    }
    const int file = open_log(path);
    if (file < 0) {
        throw input_error(path + ": the log cannot be written (" + std::strerror(errno) +
                          "); choose another folder with --out");
    }
    const std::string bytes = ulog_header(header);
    error_ = write_all(file, bytes.data(), bytes.size());
    begin_file(file, error_ == 0 ? bytes : "");
}

/* The header is in the file already; empty: it could not be written. */
void log_file::begin_file(int file, const std::string &header_bytes)
{
    file_ = file;
    whole_bytes_ = static_cast<std::int64_t>(header_bytes.size());
    block_begin_ = block_data_ = 0;
    written_sum_ = xxh64();
    written_sum_.add(header_bytes.data(), header_bytes.size());
    block_sum_ = written_sum_;
    seal(false);
}

log_file::~log_file()
{
    drain();
    if (file_ >= 0) {
        seal(true);
        close(file_);
    }
}

bool log_file::begin_part(const std::string &path, const log_header &header)
{
    const std::string bytes = ulog_header(header);
    const int next = open_log(path);
    const int failed = next < 0 ? errno : write_all(next, bytes.data(), bytes.size());
    if (failed != 0) {
        error_ = error_ != 0 ? error_ : failed;
        if (next >= 0) {
            close(next);
            unlink(path.c_str());
        }
        return false;
    }
    seal(true);
    sync_to_disk();
    close(file_);
    begin_file(next, bytes);
    return true;
}

bool log_file::push(const void *bytes, std::size_t size_bytes)
{
    count(begun_records_);
    const bool is_pushed = log_ring_push(&ring_, bytes, size_bytes) != 0;
    if (!is_pushed) {
        count(refused_records_);
    }
    count(pushed_records_);
    return is_pushed;
}

const char *log_file::trouble() const
{
    return error_ != 0 ? std::strerror(error_) : refused_records_.load() > 0 ? "the ring was full" : "";
}

void log_file::drain_if_due()
{
    if (log_ring_fill(&ring_) >= storage_.size() / 2) {
        drain();
    }
}

bool log_file::append(const void *bytes, std::size_t size_bytes)
{
    written_sum_.add(bytes, size_bytes);
    const int failed = write_all(file_, static_cast<const char *>(bytes), size_bytes);
    error_ = error_ != 0 ? error_ : failed;
    return failed == 0;
}

/* Takes `size_bytes` out of the ring and, as long as that goes well, to the file. */
bool log_file::empty_ring(std::size_t size_bytes, bool is_written)
{
    const std::uint8_t *bytes = nullptr;
    while (size_bytes > 0) {
        const std::size_t part = std::min(log_ring_peek(&ring_, &bytes), size_bytes);
        if (witness_) {
            witness_(bytes, part);
        }
        is_written = is_written && append(bytes, part);
        log_ring_take(&ring_, part);
        size_bytes -= part;
    }
    return is_written;
}

/* What has been pushed so far. A push that is under way would show in one number and not yet in another, so that
 * moment is let pass. */
log_file::progress log_file::pushed_so_far() const
{
    progress now{};
    std::uint64_t pushes = 0;
    do {
        pushes = pushed_records_.load();
        now.refused_records = refused_records_.load();
        now.ring_bytes = log_ring_fill(&ring_);
    } while (begun_records_.load() != pushes);
    now.records = pushes - now.refused_records;
    return now;
}

void log_file::drain()
{
    const progress now = pushed_so_far();
    const std::uint64_t drops = now.refused_records + unwritten_records_;
    bool is_written = whole_bytes_ > 0; /* without a header no record can be read */
    auto size_bytes = static_cast<std::int64_t>(now.ring_bytes);
    if (is_written && drops > reported_drops_) {
        std::string dropout;
        append_message(dropout, 'O', std::string(2, '\0'));
        is_written = append(dropout.data(), dropout.size());
        size_bytes += static_cast<std::int64_t>(dropout.size());
    }
    is_written = empty_ring(now.ring_bytes, is_written);
    if (is_written) {
        whole_bytes_ += size_bytes;
        block_sum_ = written_sum_;
        reported_drops_ = drops;
    } else if (file_ >= 0) {
        unwritten_records_ += now.records - drained_records_;
        truncate();
    }
    drained_records_ = now.records;
    if (file_ >= 0 && whole_bytes_ - block_begin_ >= block_bytes_min) {
        seal(false);
    }
}

/* Takes back what was not written whole. */
void log_file::truncate()
{
    written_sum_ = block_sum_;
    if (ftruncate(file_, whole_bytes_) == 0) {
        lseek(file_, whole_bytes_, SEEK_SET);
    }
}

/* Ends the block. Where the disk does not take the message, the block goes on. */
void log_file::seal(bool is_last)
{
    if (whole_bytes_ == 0) {
        return;
    }
    const std::string message =
        block_message({static_cast<std::uint64_t>(block_begin_), block_sum_.value(), is_last});
    if (append(message.data(), message.size())) {
        block_begin_ = whole_bytes_;
        whole_bytes_ += static_cast<std::int64_t>(message.size());
        block_data_ = whole_bytes_;
        written_sum_ = xxh64();
        written_sum_.add(message.data(), message.size());
        block_sum_ = written_sum_;
    } else {
        truncate();
    }
}

void log_file::sync()
{
    if (file_ < 0 || whole_bytes_ == block_data_) {
        return;
    }
    seal(false);
    sync_to_disk();
}

void log_file::sync_to_disk()
{
    if (fdatasync(file_) != 0 && errno != EINVAL && errno != EROFS) { /* a pipe or a device has no disk */
        error_ = error_ != 0 ? error_ : errno;
    }
}

} // namespace berth
