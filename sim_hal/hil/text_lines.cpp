#include "text_lines.h"

#ifdef BERTH_WITH_ZLIB
#include <zlib.h>
#endif

#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/unreadable.h"

namespace berth
{

namespace
{

/* Rows are bounded; this is for what is none: columns that nobody asked for, empty lines. */
constexpr std::size_t unpacked_bytes_max = 2000000000;
constexpr std::size_t line_bytes_max = 1u << 20;
constexpr std::size_t block_bytes = 1u << 16;
constexpr std::string_view packed_mark = "\x1f\x8b";
constexpr std::string_view byte_order_mark = "\xef\xbb\xbf"; /* spreadsheets write it */

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

text_lines::text_lines(const std::string &path) : file_(std::fopen(path.c_str(), "rb")), path_(path)
{
    if (!file_) {
        throw input_error(unreadable(path));
    }
    read_stored();
    if (stored_.compare(0, packed_mark.size(), packed_mark) == 0) {
#ifndef BERTH_WITH_ZLIB
        throw input_error(path + ": is compressed, and this program was built without zlib; gunzip it first");
#endif
        unpacker_ = std::make_unique<unpacker>();
    }
}

text_lines::~text_lines() = default;

bool text_lines::next(std::string_view &line)
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

std::string text_lines::hash() const
{
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash_));
    return text;
}

bool text_lines::fill()
{
    if (stored_.empty() && !read_stored()) {
        if (unpacker_ && !unpacker_->is_whole()) {
            throw input_error(path_ + ": cannot be read to its end; was it cut off?");
        }
        const std::string rest = std::move(undecoded_);
        undecoded_.clear();
        append(rest);
        return !rest.empty();
    }
    if (!unpacker_) {
        take_bytes(stored_);
        stored_.clear();
        return true;
    }
    std::string text;
    if (!unpacker_->take(stored_, text)) {
        throw input_error(path_ + ": cannot be unpacked to its end; is it damaged?");
    }
    take_bytes(text);
    return true;
}

bool text_lines::read_stored()
{
    stored_.resize(block_bytes);
    stored_.resize(std::fread(stored_.data(), 1, stored_.size(), file_.get()));
    if (std::ferror(file_.get()) != 0) {
        throw input_error(unreadable(path_));
    }
    for (const char c : stored_) {
        hash_ = (hash_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    }
    return !stored_.empty();
}

/* The first bytes tell the encoding: by a mark, or by the zero beside each plain letter. */
void text_lines::take_bytes(std::string_view bytes)
{
    if (encoding_ == encoding::utf8) {
        append(bytes);
        return;
    }
    undecoded_ += bytes;
    if (encoding_ == encoding::unknown) {
        if (undecoded_.size() < byte_order_mark.size() + 1) {
            return;
        }
        const auto is_zero = [&](std::size_t at) { return undecoded_[at] == '\0'; };
        const auto begins = [&](std::string_view mark) { return undecoded_.compare(0, mark.size(), mark) == 0; };
        const bool is_wider = is_zero(2) && is_zero(3); /* UTF-32 */
        if (!is_wider && (begins("\xff\xfe") || (!is_zero(0) && is_zero(1) && !is_zero(2) && is_zero(3)))) {
            encoding_ = encoding::utf16_little;
        } else if (begins("\xfe\xff") || (is_zero(0) && !is_zero(1) && is_zero(2) && !is_zero(3))) {
            encoding_ = encoding::utf16_big;
        } else {
            encoding_ = encoding::utf8;
            undecoded_.erase(0, begins(byte_order_mark) ? byte_order_mark.size() : 0);
        }
    }
    const std::string known = std::move(undecoded_);
    undecoded_.clear();
    encoding_ == encoding::utf8 ? append(known) : take_utf16(known);
}

void text_lines::take_utf16(std::string_view bytes)
{
    const std::size_t low = encoding_ == encoding::utf16_little ? 0 : 1;
    const auto unit_at = [&](std::size_t at) {
        const auto byte = [&](std::size_t i) {
            return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i]));
        };
        return byte(at + low) | byte(at + 1 - low) << 8;
    };
    const auto is_half = [](std::uint32_t unit, std::uint32_t first) {
        return unit >= first && unit < first + 0x400;
    };
    std::string text;
    std::size_t at = 0;
    while (at + 2 <= bytes.size()) {
        std::uint32_t letter = unit_at(at);
        std::size_t taken = 2;
        if (is_half(letter, 0xd800)) { /* the first half of a letter of two */
            if (at + 4 > bytes.size()) {
                break;
            }
            letter = 0x10000 + ((letter - 0xd800) << 10) + (unit_at(at + 2) & 0x3ff);
            taken = 4;
        }
        at += taken;
        if (letter == 0xfeff) { /* the byte order mark */
            continue;
        }
        if (letter < 0x80) {
            text += static_cast<char>(letter);
            continue;
        }
        constexpr std::uint32_t first_byte[] = {0, 0xc0, 0xe0, 0xf0}; /* of UTF-8, by the bytes that follow it */
        const int further = letter < 0x800 ? 1 : letter < 0x10000 ? 2 : 3;
        text += static_cast<char>(first_byte[further] | letter >> (6 * further));
        for (int i = further - 1; i >= 0; i--) {
            text += static_cast<char>(0x80 | (letter >> (6 * i) & 0x3f));
        }
    }
    undecoded_ = bytes.substr(at);
    append(text);
}

void text_lines::append(std::string_view text)
{
    text_bytes_ += text.size();
    if (text_bytes_ > unpacked_bytes_max) {
        throw input_error(path_ + ": is larger than 2 GB of text; give a part of it");
    }
    for (const char c : text) {
        if (c != '\n' || !was_return_) {
            buffer_ += c == '\r' ? '\n' : c;
        }
        was_return_ = c == '\r';
    }
}

} // namespace berth
