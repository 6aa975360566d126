/* The table of rig file keys: the one place that says which keys there are, what they may be and what they mean. */
#ifndef HAL_RIG_KEYS_H
#define HAL_RIG_KEYS_H

#include <string>
#include <string_view>
#include <vector>

#include "rig.h"

namespace berth
{

enum class key_type { number, integer, boolean, choice, text };

struct rig_key {
    std::string_view path; /* section.name */
    key_type type;
    void *(*own_member)(rig &); /* nullptr: one of rig::effect_values */
    bool is_bool;               /* boolean stored as bool rather than std::int32_t */
    double low;                 /* number, integer: smallest permitted value */
    double high;
    bool low_is_allowed;
    bool infinity_is_allowed;
    std::vector<std::string_view> choices;
    std::string_view meaning;
    std::size_t effect_value = 0;
    /* Further bounds, which rig.cpp or the firmware checks in words of its own. */
    double least = -unlimited;
    double most = unlimited;

    /* double, std::int64_t, std::int32_t (boolean, choice), bool or std::string */
    void *member(rig &of) const { return own_member != nullptr ? own_member(of) : &of.effect_values[effect_value]; }
};

/* A key of an effect that can be switched into a block; 0: the effect is not there. */
struct effect_key {
    std::string_view path;
    double low;
    std::string_view meaning;
    std::string_view needed_with; /* a key that counts only while this one is not 0; empty: none does */
};

/* Given by the program: sim_hal/effects has those of the simulated rig. */
const std::vector<effect_key> &effect_keys();

const std::vector<rig_key> &rig_keys();

/* The key with this path, or nullptr. */
const rig_key *find_key(std::string_view path);

/* The known path most like `path`, by edit distance; a bare name is compared with names. */
std::string_view nearest_key(std::string_view path);

/* Levenshtein distance. */
std::size_t edit_distance(std::string_view a, std::string_view b);

/* Edit distance to a key, or to the key without its unit, which counts one; 0 where only the unit is missing. */
std::size_t key_distance(std::string_view wanted, std::string_view known);

/* The section most like `name`, which is `name` itself if there is one. */
std::string_view nearest_section(std::string_view name);

/* Sets one value from its text as in a rig file (numbers, true/false, bare or quoted words). */
std::optional<rig_error> set_value(rig &rig, std::string_view path, std::string_view text);

/* Text in quotes, as TOML wants it. */
std::string in_quotes(std::string_view text);

/* A character that neither a name nor TOML text may hold as it is. */
bool is_control(char c);

/* What is wrong with a text value, if anything: a log carries the whole rig in one message of 64 KiB. */
constexpr std::size_t text_bytes_max = 2000;
std::optional<std::string> text_error(std::string_view text);

/* Current value as it stands in a rig file. Numbers read back to the same bits. */
std::string value_text(const rig &rig, const rig_key &key);

} // namespace berth

#endif
