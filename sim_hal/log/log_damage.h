/* How much of a log is whole, and where it is damaged, in bytes and in time: from the checksums of its blocks. */
#ifndef SIM_HAL_LOG_LOG_DAMAGE_H
#define SIM_HAL_LOG_LOG_DAMAGE_H

#include <optional>
#include <string>
#include <string_view>

#include "../../hal/log_blocks.h"

namespace berth
{

struct log_damage {
    byte_range bytes;                    /* somewhere in these; all before them is whole */
    std::optional<double> last_whole_s;  /* the last tick before it; none: there is no tick */
    std::optional<double> whole_again_s; /* the first whole tick behind it; none: there is no whole block */
};

/* How much of a log can be read. */
struct log_condition {
    bool has_checksums = false; /* else nobody can know of damage: it is older, or another program saved it again */
    bool is_cut = false;        /* ends within a message, or without the message that ends a log */
    std::optional<log_damage> damage;    /* the first one */
    std::optional<double> whole_until_s; /* the last whole tick before a cut, a damage or the end; none: not known */
};

/* Of a file, from a check of its blocks. */
log_condition condition_of(std::string_view file, const log_check &check);

/* "is damaged between byte 3 and byte 5, after 1.2 s and before 1.4 s". */
std::string text_of(const log_damage &damage);

} // namespace berth

#endif
