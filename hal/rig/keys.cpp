#include "keys.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "key_table.h"
#include "names.h"
#include "toml_remedy.h"

namespace berth
{

namespace
{

std::string_view bare_name(std::string_view path)
{
    const std::size_t dot = path.rfind('.');
    return dot == std::string_view::npos ? path : path.substr(dot + 1);
}

std::string range_text(const rig_key &key)
{
    if (key.high == 1.0) {
        return "must be from 0 to 1";
    }
    return key.low_is_allowed ? "must be 0 or more" : "must be greater than 0";
}

bool in_range(const rig_key &key, double value)
{
    return value <= key.high && (key.low_is_allowed ? value >= key.low : value > key.low);
}

template <typename T>
bool parse(std::string_view text, T &value)
{
    if (!text.empty() && text.front() == '+') {
        text.remove_prefix(1);
    }
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

std::string without_underscores(std::string_view text)
{
    std::string result(text);
    result.erase(std::remove(result.begin(), result.end(), '_'), result.end());
    return result;
}

std::optional<rig_error> set_choice(rig &rig, const rig_key &key, std::string_view word)
{
    const auto found = std::find(key.choices.begin(), key.choices.end(), word);
    if (found == key.choices.end()) {
        std::string message = "must be one of";
        for (const auto choice : key.choices) {
            message += (choice == key.choices.front() ? " \"" : ", \"") + std::string(choice) + "\"";
        }
        return rig_error{std::string(key.path), message + " (is \"" + std::string(word) + "\")" +
                                                    did_you_mean({key.choices.begin(), key.choices.end()}, word)};
    }
    *static_cast<std::int32_t *>(key.member(rig)) = static_cast<std::int32_t>(found - key.choices.begin());
    return {};
}

std::optional<rig_error> set_boolean(rig &rig, const rig_key &key, std::string_view text)
{
    if (text != "true" && text != "false") {
        return rig_error{std::string(key.path), "must be true or false (is " + std::string(text) + ")"};
    }
    if (key.is_bool) {
        *static_cast<bool *>(key.member(rig)) = text == "true";
    } else {
        *static_cast<std::int32_t *>(key.member(rig)) = text == "true";
    }
    return {};
}

std::optional<rig_error> set_number(rig &rig, const rig_key &key, std::string_view text)
{
    double value = 0.0;
    if (!parse(without_underscores(text), value)) {
        const std::string remedy = number_remedy(text);
        return rig_error{std::string(key.path),
                         "must be a number (is " + std::string(text) + ")" + (remedy.empty() ? "" : "; " + remedy)};
    }
    if (std::isnan(value) || (std::isinf(value) && !key.infinity_is_allowed)) {
        return rig_error{std::string(key.path), "must be a finite number (is " + std::string(text) +
                                                    "); write a number, or leave the key out"};
    }
    if (!in_range(key, value)) {
        return rig_error{std::string(key.path), range_text(key) + " (is " + std::string(text) + ")"};
    }
    if (key.type == key_type::number) {
        *static_cast<double *>(key.member(rig)) = value;
        return {};
    }
    if (value != std::floor(value) || std::abs(value) > 9e15) {
        return rig_error{std::string(key.path), "must be a whole number (is " + std::string(text) + ")"};
    }
    *static_cast<std::int64_t *>(key.member(rig)) = static_cast<std::int64_t>(value);
    return {};
}

} // namespace

std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); i++) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); j++) {
            const std::size_t above = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
            diagonal = above;
        }
    }
    return row[b.size()];
}

std::size_t key_distance(std::string_view wanted, std::string_view known)
{
    std::size_t shortest = edit_distance(wanted, known);
    std::size_t end = known.find('_', known.rfind('.') == std::string_view::npos ? 0 : known.rfind('.'));
    while (end != std::string_view::npos) {
        const std::string_view without_unit = known.substr(0, end);
        shortest = std::min(shortest, without_unit == wanted ? 0 : edit_distance(wanted, without_unit) + 1);
        end = known.find('_', end + 1);
    }
    return shortest;
}

const std::vector<rig_key> &rig_keys()
{
    static const std::vector<rig_key> keys = make_keys();
    return keys;
}

const rig_key *find_key(std::string_view path)
{
    const auto &keys = rig_keys();
    const auto found = std::find_if(keys.begin(), keys.end(), [&](const rig_key &key) { return key.path == path; });
    return found == keys.end() ? nullptr : &*found;
}

std::string_view nearest_key(std::string_view path)
{
    const bool has_section = path.find('.') != std::string_view::npos;
    const auto &keys = rig_keys();
    /* The beginning of a key, cut off before its unit, is nearer than all else. */
    const auto to_wanted = [&](const rig_key &key) {
        const std::string_view known = has_section ? key.path : bare_name(key.path);
        return known.substr(0, path.size()) == path ? 0 : key_distance(path, known);
    };
    return std::min_element(keys.begin(), keys.end(),
                            [&](const rig_key &a, const rig_key &b) { return to_wanted(a) < to_wanted(b); })
        ->path;
}

std::string_view nearest_section(std::string_view name)
{
    const auto section_of = [](const rig_key &key) { return key.path.substr(0, key.path.find('.')); };
    const auto &keys = rig_keys();
    return section_of(*std::min_element(keys.begin(), keys.end(), [&](const rig_key &a, const rig_key &b) {
        return edit_distance(name, section_of(a)) < edit_distance(name, section_of(b));
    }));
}

std::optional<rig_error> set_value(rig &rig, std::string_view path, std::string_view text)
{
    const rig_key *key = find_key(path);
    if (key == nullptr && path.substr(0, 7) == "orders.") {
        return rig_error{"orders", "orders are a list: each begins with [[orders]], in two brackets"};
    }
    if (key == nullptr && path.find('.') == std::string_view::npos && nearest_section(path) == path) {
        const bool is_robot = path == "robot" && !text.empty();
        return rig_error{std::string(path),
                         "is a section: name one of its keys, as " +
                             std::string(nearest_key(std::string(path) + ".")) +
                             (is_robot ? "; a preset is chosen by --robot " + std::string(text) : "")};
    }
    if (key == nullptr) {
        return rig_error{std::string(path), unknown_key_words(path)};
    }
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
        text = text.substr(1, text.size() - 2);
    }
    switch (key->type) {
    case key_type::text:
        if (const auto error = text_error(text)) {
            return rig_error{std::string(path), *error};
        }
        *static_cast<std::string *>(key->member(rig)) = std::string(text);
        return {};
    case key_type::choice:
        return set_choice(rig, *key, text);
    case key_type::boolean:
        return set_boolean(rig, *key, text);
    default:
        return set_number(rig, *key, text);
    }
}

std::string in_quotes(std::string_view text)
{
    std::string result = "\"";
    for (const char c : text) {
        if (is_control(c)) {
            char code[8];
            std::snprintf(code, sizeof code, "\\u%04X", static_cast<unsigned>(c));
            result += code;
            continue;
        }
        if (c == '"' || c == '\\') {
            result += '\\';
        }
        result += c;
    }
    return result + '"';
}

bool is_control(char c)
{
    const auto byte = static_cast<unsigned char>(c); /* char has a sign here and none on arm64 */
    return byte < ' ' || byte == 0x7f;
}

std::optional<std::string> text_error(std::string_view text)
{
    if (text.size() <= text_bytes_max) {
        return {};
    }
    return "must not be longer than " + std::to_string(text_bytes_max) + " bytes (is " +
           std::to_string(text.size()) + ")";
}

std::string value_text(const rig &rig, const rig_key &key)
{
    void *member = key.member(const_cast<berth::rig &>(rig));
    switch (key.type) {
    case key_type::text:
        return in_quotes(*static_cast<std::string *>(member));
    case key_type::choice:
        return '"' + std::string(key.choices[static_cast<std::size_t>(*static_cast<std::int32_t *>(member))]) + '"';
    case key_type::boolean:
        return (key.is_bool ? *static_cast<bool *>(member) : *static_cast<std::int32_t *>(member) != 0) ? "true"
                                                                                                        : "false";
    case key_type::integer:
        return std::to_string(*static_cast<std::int64_t *>(member));
    case key_type::number:
        break;
    }
    char text[32];
    const auto [end, error] = std::to_chars(text, text + sizeof text, *static_cast<double *>(member));
    std::string result(text, end);
    const bool is_whole = result.find_first_not_of("-0123456789") == std::string::npos;
    return is_whole ? result + ".0" : result;
}

} // namespace berth
