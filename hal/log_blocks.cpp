#include "log_blocks.h"

#include <charconv>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <vector>

#include "xxh64.h"

namespace berth
{

namespace
{

constexpr std::string_view block_key = "\x14"
                                       "char[38] berth_block";
constexpr std::size_t block_text_bytes = 38;
constexpr std::size_t begin_digits = 16; /* hexadecimal, with which the text begins */
constexpr std::size_t block_content_bytes = block_key.size() + block_text_bytes;
constexpr std::size_t block_message_bytes = ulog_message_header_bytes + block_content_bytes;

std::uint64_t checksum_of(std::string_view bytes)
{
    xxh64 sum;
    sum.add(bytes.data(), bytes.size());
    return sum.value();
}

/* A place in a file that looks like the end of a block. */
struct seal {
    std::size_t at;
    std::size_t end;
    std::uint64_t begin_byte = 0;
    bool fits = false; /* the message is whole, and its checksum is that of its block */
    bool is_last = false;
};

/* No block begins before the message that ended the one before, at `begin_min`: so each byte is summed once at most,
 * whatever a file claims. */
seal read_seal(std::string_view file, std::size_t at, std::size_t begin_min)
{
    seal seal{at, at + block_message_bytes};
    const std::string_view message = file.substr(at, block_message_bytes);
    const std::string_view text = message.substr(ulog_message_header_bytes + block_key.size());
    seal.is_last = text.substr(text.size() - 4) == "last";
    const auto [end, error] = std::from_chars(text.data(), text.data() + begin_digits, seal.begin_byte, 16);
    if (error == std::errc() && seal.begin_byte >= begin_min && seal.begin_byte <= at) {
        const std::uint64_t sum = checksum_of(file.substr(seal.begin_byte, at - seal.begin_byte));
        seal.fits = message == block_message({seal.begin_byte, sum, seal.is_last});
    }
    return seal;
}

/* All of a file, in their order. One that the zeros of a cut reach into is none. */
std::vector<seal> read_seals(std::string_view file, std::size_t nonzero_bytes)
{
    std::vector<seal> seals;
    for (std::size_t key = file.find(block_key); key != std::string_view::npos;
         key = file.find(block_key, key + block_key.size())) {
        const std::size_t at = key - ulog_message_header_bytes;
        if (key >= ulog_message_header_bytes && at + block_message_bytes <= nonzero_bytes) {
            seals.push_back(read_seal(file, at, seals.empty() ? 0 : seals.back().at));
        }
    }
    return seals;
}

/* Where berth ends a block, records follow, or another block, or nothing. A program that saves the log again keeps
 * one message of all, and puts it before others of the header. */
bool is_of_saved_again(std::string_view file, const std::vector<seal> &seals)
{
    constexpr std::string_view types_of_header = "AIMPQ";
    const seal &only = seals.front();
    return seals.size() == 1 && !only.fits && file.size() > only.end + 2 &&
           types_of_header.find(file[only.end + 2]) != std::string_view::npos;
}

/* The records behind the last block that fits. A power cut ends them within a message or with zeros: what is whole
 * of them can be read. Anything else there is damage. */
void check_tail(std::string_view file, std::size_t nonzero_bytes, log_check &check)
{
    const std::size_t begin = check.readable_bytes;
    std::size_t nonzero_end = begin; /* of the messages that the zeros do not reach into */
    for (std::size_t at = begin; at < file.size();) {
        std::uint16_t size_bytes = 0;
        if (file.size() - at < ulog_message_header_bytes) {
            return;
        }
        std::memcpy(&size_bytes, file.data() + at, sizeof size_bytes);
        const std::size_t end = at + ulog_message_header_bytes + size_bytes;
        if (file[at + 2] != 'D' && file[at + 2] != 'O') {
            const bool is_cut_seal = file[at + 2] == 'I' && size_bytes == block_content_bytes && end > nonzero_bytes;
            check.readable_bytes = nonzero_end;
            if (at + ulog_message_header_bytes <= nonzero_bytes && !is_cut_seal) {
                check.readable_bytes = begin;
                check.damage = {begin, file.size()};
            }
            return;
        }
        at = end;
        check.readable_bytes = at <= file.size() ? at : check.readable_bytes;
        nonzero_end = at <= nonzero_bytes ? at : nonzero_end;
    }
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
    const std::size_t nonzero_bytes = file.find_last_not_of('\0') + 1;
    const std::vector<seal> seals = read_seals(file, nonzero_bytes);
    check.has_blocks = !seals.empty() && !is_of_saved_again(file, seals);
    if (!check.has_blocks) {
        return check;
    }
    auto next = seals.begin();
    std::uint64_t begin_byte = 0;
    for (; next != seals.end() && !check.is_ended && next->fits && next->begin_byte == begin_byte; next++) {
        begin_byte = next->at;
        check.readable_bytes = next->end;
        check.is_ended = next->is_last;
    }
    const std::uint64_t whole_bytes = check.readable_bytes;
    if (!check.is_ended && next == seals.end()) {
        check_tail(file, nonzero_bytes, check);
    } else if (whole_bytes < file.size()) {
        while (next != seals.end() && (check.is_ended || !next->fits || next->begin_byte < whole_bytes)) {
            next++;
        }
        check.damage = {whole_bytes, next != seals.end() ? next->begin_byte : file.size()};
    }
    return check;
}

} // namespace berth
