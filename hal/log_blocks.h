/* A log is a row of blocks, each of which ends with a message that carries the checksum of what is before it: what a
 * power cut or a disk has spoilt is found, with its place. Other programs see the messages as informations, which
 * the format has room for anywhere:
 *
 *     'I', key "char[38] berth_block", text "BEGIN CHECKSUM more" or "BEGIN CHECKSUM last"
 *
 * BEGIN: the block's first byte in the file; CHECKSUM: XXH64 of the bytes from there up to this message; both in 16
 * hexadecimal digits. The next block begins behind the message, and behind the last one nothing follows. The first
 * block is the header with its subscriptions. */
#ifndef HAL_LOG_BLOCKS_H
#define HAL_LOG_BLOCKS_H

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace berth
{

struct log_block {
    std::uint64_t begin_byte;
    std::uint64_t checksum;
    bool is_last;
};

/* The message that ends a block, whole. */
std::string block_message(const log_block &block);

/* What the blocks of a file show. */
struct log_check {
    bool has_blocks = false;      /* else it is older than blocks, or was saved again by another program */
    bool is_ended = false;        /* by a last block */
    std::uint64_t whole_byte = 0; /* up to here every checksum fits */
    /* Behind that, something is damaged; noticed here. */
    std::optional<std::uint64_t> damaged_byte;
};

/* Reads the messages of a ULog file. Never throws for what is inside. */
log_check check_blocks(std::string_view file);

} // namespace berth

#endif
