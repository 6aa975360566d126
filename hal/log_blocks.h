/* A log is a row of blocks. Each block ends with a message that carries the checksum of the bytes before it, so that
 * a reader finds damage, with its place. Other programs see these messages as information messages, which ULog
 * allows anywhere:
 *
 *     'I', key "char[38] berth_block", text "BEGIN CHECKSUM more" or "BEGIN CHECKSUM last"
 *
 * BEGIN: the block's first byte in the file. CHECKSUM: XXH64, seed 0, of the bytes from there up to this message.
 * Both are 16 hexadecimal digits. The next block begins with this message, so that it does not fit behind a block of
 * another log; behind the last one nothing follows. The first block is the header with its subscriptions.
 *
 * A program that saves a log again drops these messages, or moves one of them before the subscriptions. Such a log
 * counts as one without checksums, and so does one from before checksums. */
#ifndef HAL_LOG_BLOCKS_H
#define HAL_LOG_BLOCKS_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace berth
{

/* Of the format. */
constexpr std::size_t ulog_file_header_bytes = 16;
constexpr std::size_t ulog_message_header_bytes = 3; /* length of the content, type */

struct log_block {
    std::uint64_t begin_byte;
    std::uint64_t checksum;
    bool is_last;
};

/* The message that ends a block, whole. */
std::string block_message(const log_block &block);

/* [from, to) of a file. */
struct byte_range {
    std::uint64_t from_byte;
    std::uint64_t to_byte;
};

/* What the blocks of a file show. */
struct log_check {
    bool has_blocks = false; /* else the file has no checksums, and nothing below is known */
    bool is_ended = false;   /* by a last block */
    /* To be read: behind it comes damage, or what a power cut left of a message. */
    std::uint64_t readable_bytes = 0;
    /* The first damage. Its end is the first byte of a block whose checksum fits again, or the end of the file. */
    std::optional<byte_range> damage;
};

/* Reads the blocks of a ULog file. Never throws for what is inside. */
log_check check_blocks(std::string_view file);

} // namespace berth

#endif
