#include "log_blocks.h"

#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "xxh64.h"

namespace berth
{

namespace
{

constexpr std::size_t file_header_bytes = 16;
constexpr std::size_t message_header_bytes = 3;
constexpr std::string_view block_key = "\x14"
                                       "char[38] berth_block";
constexpr std::size_t block_text_bytes = 38;
constexpr std::size_t block_content_bytes = block_key.size() + block_text_bytes;

std::uint64_t checksum_of(std::string_view bytes)
{
    xxh64 sum;
    sum.add(bytes.data(), bytes.size());
    return sum.value();
}

bool is_block(char type, std::string_view content)
{
    return type == 'I' && content.size() == block_content_bytes && content.substr(0, block_key.size()) == block_key;
}

/* Our own logs have nothing else behind their header. */
bool belongs_in_block(char type, std::uint16_t size_bytes)
{
    return type == 'D' || type == 'O' || (type == 'I' && size_bytes == block_content_bytes);
}

} // namespace

std::string block_message(const log_block &block)
{
    char text[block_text_bytes + 1];
    std::snprintf(text, sizeof text, "%016" PRIx64 " %016" PRIx64 " %s", block.begin_byte, block.checksum,
                  block.is_last ? "last" : "more");
    const std::uint16_t size_bytes = block_content_bytes;
    std::string message(reinterpret_cast<const char *>(&size_bytes), sizeof size_bytes);
    return message.append("I").append(block_key).append(text);
}

log_check check_blocks(std::string_view file)
{
    log_check check;
    const bool has_several = file.find(block_key) != file.rfind(block_key); /* a log that was saved again has one */
    bool has_topics = false; /* programs that save a log again put the text of a block before them */
    for (std::size_t at = file_header_bytes; at < file.size();) {
        if (check.is_ended) {
            check.damaged_byte = at;
            return check;
        }
        std::uint16_t size_bytes = 0;
        const bool has_header = file.size() - at >= message_header_bytes;
        std::memcpy(&size_bytes, file.data() + at, has_header ? sizeof size_bytes : 0);
        const char type = has_header ? file[at + 2] : 'D';
        if (check.has_blocks && !belongs_in_block(type, size_bytes)) {
            check.damaged_byte = at;
            return check;
        }
        const std::size_t end = at + message_header_bytes + size_bytes;
        if (end > file.size()) { /* cut; but a header that leads beyond the end of a file with blocks is damaged */
            check.has_blocks = check.has_blocks || has_several;
            check.damaged_byte =
                check.whole_byte == 0 && has_several ? std::optional<std::uint64_t>(at) : std::nullopt;
            return check;
        }
        const std::string_view content = file.substr(at + message_header_bytes, size_bytes);
        has_topics = has_topics || type == 'A';
        if (has_topics && (check.has_blocks ? type == 'I' : is_block(type, content))) {
            const std::uint64_t sum = checksum_of(file.substr(check.whole_byte, at - check.whole_byte));
            const std::string_view message = file.substr(at, end - at);
            check.has_blocks = true;
            check.is_ended = message == block_message({check.whole_byte, sum, true});
            if (!check.is_ended && message != block_message({check.whole_byte, sum, false})) {
                check.damaged_byte = at;
                return check;
            }
            check.whole_byte = end;
        }
        at = end;
    }
    return check;
}

} // namespace berth
