#include "log_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "rig/rig_file.h"

namespace berth
{

namespace
{

constexpr std::size_t ring_bytes = std::size_t{1} << 18; /* stays in a second-level cache */

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

log_file::log_file(const std::string &path, const log_header &header) : storage_(ring_bytes)
{
    log_ring_start(&ring_, storage_.data(), storage_.size());
    if (path.empty()) {
        return;
    }
    const std::filesystem::path folder = std::filesystem::path(path).parent_path();
    std::error_code no_folder; /* open() then says why not */
    std::filesystem::create_directories(folder.empty() ? "." : folder, no_folder);
    file_ = open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file_ < 0) {
        throw input_error(path + ": the log cannot be written (" + std::strerror(errno) +
                          "); choose another folder with --out");
    }
    const std::string bytes = ulog_header(header);
    if (write_all(reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size())) {
        whole_bytes_ = static_cast<std::int64_t>(bytes.size());
    }
}

log_file::~log_file()
{
    drain();
    if (file_ >= 0) {
        close(file_);
    }
}

bool log_file::push(const void *bytes, std::size_t size_bytes)
{
    if (!log_ring_push(&ring_, bytes, size_bytes)) {
        dropped_records_++;
        if (trouble_.empty()) {
            trouble_ = "more in one tick than the ring holds";
        }
        return false;
    }
    records_in_ring_++;
    return true;
}

void log_file::drain_if_due()
{
    if (log_ring_fill(&ring_) >= ring_bytes / 2) {
        drain();
    }
}

bool log_file::write_all(const std::uint8_t *bytes, std::size_t size_bytes)
{
    while (size_bytes > 0) {
        const ssize_t written = write(file_, bytes, size_bytes);
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written <= 0) {
            if (trouble_.empty()) {
                trouble_ = std::strerror(errno);
            }
            return false;
        }
        bytes += written;
        size_bytes -= static_cast<std::size_t>(written);
    }
    return true;
}

void log_file::drop_ring()
{
    const std::uint8_t *bytes = nullptr;
    while (const std::size_t size = log_ring_peek(&ring_, &bytes)) {
        log_ring_take(&ring_, size);
    }
}

void log_file::drain()
{
    const std::uint8_t *bytes = nullptr;
    bool is_written = whole_bytes_ > 0; /* without a header no record can be read */
    std::int64_t size_bytes = 0;
    if (is_written && dropped_records_ > reported_drops_) {
        std::string dropout;
        append_message(dropout, 'O', std::string(2, '\0'));
        is_written = write_all(reinterpret_cast<const std::uint8_t *>(dropout.data()), dropout.size());
        size_bytes += static_cast<std::int64_t>(dropout.size());
    }
    while (is_written) {
        const std::size_t size = log_ring_peek(&ring_, &bytes);
        if (size == 0) {
            break;
        }
        is_written = write_all(bytes, size);
        log_ring_take(&ring_, size);
        size_bytes += static_cast<std::int64_t>(size);
    }
    if (is_written) {
        whole_bytes_ += size_bytes;
        reported_drops_ = dropped_records_;
    } else if (file_ >= 0) {
        dropped_records_ += records_in_ring_;
        if (ftruncate(file_, whole_bytes_) == 0) {
            lseek(file_, whole_bytes_, SEEK_SET);
        }
    }
    drop_ring();
    records_in_ring_ = 0;
}

} // namespace berth
