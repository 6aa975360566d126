#include "terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace berth
{

namespace
{

constexpr std::size_t narrowest = 40; /* below that, the terminal's own breaks read better */

/* Bytes of an escape sequence, such as a colour, that begins here; 0: none does. */
std::size_t escape_bytes(std::string_view text)
{
    if (text.size() < 2 || text[0] != '\033' || text[1] != '[') {
        return 0;
    }
    const std::size_t end = text.find_first_of("mK", 2);
    return end == std::string_view::npos ? 0 : end + 1;
}

/* In columns of the terminal: UTF-8, one column a character. */
std::size_t columns_of(std::string_view text)
{
    std::size_t columns = 0;
    for (std::size_t i = 0; i < text.size();) {
        if (const std::size_t escape = escape_bytes(text.substr(i)); escape > 0) {
            i += escape;
            continue;
        }
        columns += (static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U ? 1 : 0;
        i++;
    }
    return columns;
}

/* Where the text of a line goes on; nothing: it is a row of a table. */
std::optional<std::size_t> indent_of(std::string_view line)
{
    const std::size_t start = std::min(line.find_first_not_of(' '), line.size());
    std::optional<std::size_t> text_at;
    for (std::size_t gap = line.find("  ", start); gap != std::string_view::npos;) {
        const std::size_t next = line.find_first_not_of(' ', gap);
        if (next == std::string_view::npos) {
            break;
        }
        if (text_at) {
            return {};
        }
        text_at = next;
        gap = line.find("  ", next);
    }
    constexpr std::size_t is_continuation = 10; /* a line that stands under a text already */
    return text_at ? columns_of(line.substr(0, *text_at)) : start >= is_continuation ? start : start + 2;
}

} // namespace

std::size_t terminal_width(int file_descriptor)
{
    if (isatty(file_descriptor) == 0) {
        return 0;
    }
    if (const char *const columns = std::getenv("COLUMNS")) {
        if (const long asked = std::strtol(columns, nullptr, 10); asked > 0) {
            return static_cast<std::size_t>(asked);
        }
    }
    winsize size{};
    return ioctl(file_descriptor, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

std::string wrapped(std::string_view line, std::size_t width)
{
    const std::optional<std::size_t> indent = indent_of(line);
    if (width < narrowest || columns_of(line) <= width || !indent) {
        return std::string(line);
    }
    const std::size_t hanging = std::min(*indent, width / 2);
    const std::size_t start = std::min(line.find_first_not_of(' '), line.size());
    std::string result(line.substr(0, start));
    std::size_t used = start;
    for (std::size_t at = start; at < line.size();) {
        const std::size_t gap = std::min(line.find_first_not_of(' ', at), line.size()) - at;
        const std::size_t end = std::min(line.find(' ', at + gap), line.size());
        const std::string_view word = line.substr(at + gap, end - at - gap);
        const std::size_t columns = columns_of(word);
        if (gap > 0 && used > hanging && used + gap + columns > width) {
            result += "\n" + std::string(hanging, ' ');
            used = hanging;
        } else {
            result.append(gap, ' ');
            used += gap;
        }
        result += word;
        used += columns;
        at = end;
    }
    return result;
}

wrapped_stream::wrapped_stream(std::FILE *&stream, int file_descriptor)
    : stream_(stream), plain_(stream), width_(terminal_width(file_descriptor))
{
    if (width_ < narrowest) {
        return;
    }
    cookie_io_functions_t functions{};
    functions.write = write;
    wrapping_ = fopencookie(this, "w", functions);
    if (wrapping_ != nullptr) {
        std::setvbuf(wrapping_, nullptr, _IONBF, 0);
        stream_ = wrapping_;
    }
}

wrapped_stream::~wrapped_stream()
{
    if (wrapping_ == nullptr) {
        return;
    }
    stream_ = plain_;
    std::fclose(wrapping_);
    if (!line_.empty()) {
        std::fputs(wrapped(line_, width_).c_str(), plain_);
    }
    std::fflush(plain_);
}

ssize_t wrapped_stream::write(void *self, const char *text, std::size_t bytes)
{
    static_cast<wrapped_stream *>(self)->take({text, bytes});
    return static_cast<ssize_t>(bytes);
}

void wrapped_stream::take(std::string_view text)
{
    line_ += text;
    for (std::size_t end = line_.find('\n'); end != std::string::npos; end = line_.find('\n')) {
        const std::string line = line_.substr(0, end);
        const bool is_progress = line.find('\r') != std::string::npos;
        std::fputs(((is_progress ? line : wrapped(line, width_)) + "\n").c_str(), plain_);
        line_.erase(0, end + 1);
    }
    if (!line_.empty() && line_.front() == '\r') {
        std::fputs(line_.c_str(), plain_);
        line_.clear();
    }
    std::fflush(plain_);
}

} // namespace berth
