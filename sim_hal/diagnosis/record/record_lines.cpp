#include "record_lines.h"

#ifdef BERTH_WITH_ZLIB
#include <zlib.h>
#endif

#include "../../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

/* Rows are bounded; this is for what is none: columns that nobody asked for, empty lines. */
constexpr std::size_t unpacked_bytes_max = 2000000000;
constexpr std::size_t line_bytes_max = 1u << 20;
constexpr std::size_t block_bytes = 1u << 16;
constexpr std::string_view packed_mark = "\x1f\x8b";

} // namespace

#ifdef BERTH_WITH_ZLIB
class unpacker
{
  public:
    unpacker()
    {
        constexpr int gzip_alone = 16 + MAX_WBITS;
        is_sound_ = inflateInit2(&stream_, gzip_alone) == Z_OK;
    }
    ~unpacker() { inflateEnd(&stream_); }
    unpacker(const unpacker &) = delete;
    unpacker &operator=(const unpacker &) = delete;

    /* Takes from `stored` what makes up to a block of text; false: it is damaged. */
    bool take(std::string &stored, std::string &text)
    {
        if (is_whole_ && stored.compare(0, packed_mark.size(), packed_mark) == 0) {
            inflateReset(&stream_); /* packed files one after another count as one */
            is_whole_ = false;
        }
        if (is_whole_) {
            stored.clear(); /* padding, as gunzip has it */
            return true;
        }
        text.resize(block_bytes);
        stream_.next_in = reinterpret_cast<Bytef *>(stored.data());
        stream_.avail_in = static_cast<uInt>(stored.size());
        stream_.next_out = reinterpret_cast<Bytef *>(text.data());
        stream_.avail_out = static_cast<uInt>(text.size());
        const int result = inflate(&stream_, Z_NO_FLUSH);
        text.resize(text.size() - stream_.avail_out);
        stored.erase(0, stored.size() - stream_.avail_in);
        is_whole_ = result == Z_STREAM_END;
        return is_sound_ && (result == Z_OK || result == Z_STREAM_END || result == Z_BUF_ERROR);
    }

    /* All that was begun has ended. */
    bool is_whole() const { return is_whole_; }

  private:
    z_stream stream_{};
    bool is_sound_ = false;
    bool is_whole_ = false;
};
#else
class unpacker
{
  public:
    bool take(std::string &, std::string &) { return false; }
    bool is_whole() const { return true; }
};
#endif

record_lines::record_lines(const std::string &path) : file_(std::fopen(path.c_str(), "rb")), path_(path)
{
    if (!file_) {
        throw input_error(path + ": cannot be read; is it a file?");
    }
    read_stored();
    if (stored_.compare(0, packed_mark.size(), packed_mark) == 0) {
#ifndef BERTH_WITH_ZLIB
        throw input_error(path + ": is compressed, and this program was built without zlib; gunzip it first");
#endif
        unpacker_ = std::make_unique<unpacker>();
    }
}

record_lines::~record_lines() = default;

bool record_lines::next(std::string_view &line)
{
    for (;;) {
        const std::size_t end = buffer_.find('\n', at_);
        if (end != std::string::npos) {
            line = std::string_view(buffer_).substr(at_, end - at_);
            at_ = end + 1;
            number_++;
            return true;
        }
        buffer_.erase(0, at_);
        at_ = 0;
        if (buffer_.size() > line_bytes_max) {
            throw input_error(path_ + ": has a line of more than a megabyte; is it a CSV file?");
        }
        if (!fill()) {
            line = buffer_;
            at_ = buffer_.size();
            number_++;
            return !buffer_.empty();
        }
    }
}

std::string record_lines::hash() const
{
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash_));
    return text;
}

bool record_lines::fill()
{
    if (stored_.empty() && !read_stored()) {
        if (unpacker_ && !unpacker_->is_whole()) {
            throw input_error(path_ + ": cannot be read to its end; was it cut off?");
        }
        return false;
    }
    if (!unpacker_) {
        append(stored_);
        stored_.clear();
        return true;
    }
    std::string text;
    if (!unpacker_->take(stored_, text)) {
        throw input_error(path_ + ": cannot be unpacked to its end; is it damaged?");
    }
    append(text);
    return true;
}

bool record_lines::read_stored()
{
    stored_.resize(block_bytes);
    stored_.resize(std::fread(stored_.data(), 1, stored_.size(), file_.get()));
    if (std::ferror(file_.get()) != 0) {
        throw input_error(path_ + ": cannot be read; is it a file?");
    }
    for (const char c : stored_) {
        hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    }
    return !stored_.empty();
}

void record_lines::append(std::string_view text)
{
    text_bytes_ += text.size();
    if (text_bytes_ > unpacked_bytes_max) {
        throw input_error(path_ + ": is larger than 2 GB of text; give a part of it, a minute is plenty");
    }
    for (const char c : text) {
        if (c != '\n' || !was_return_) {
            buffer_ += c == '\r' ? '\n' : c;
        }
        was_return_ = c == '\r';
    }
}

} // namespace berth
