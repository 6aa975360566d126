#include "toml_file.h"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "keys.h"
#include "rig_file.h"
#include "toml_remedy.h"

namespace berth
{

namespace
{

bool type_fits(const rig_key &key, const toml::node &value)
{
    switch (key.type) {
    case key_type::boolean:
        return value.is_boolean();
    case key_type::choice:
    case key_type::text:
        return value.is_string();
    default:
        return value.is_number();
    }
}

/* The line at whose end the parser's checks stop it. */
std::size_t line_of_failed_check(const std::string &text)
{
    std::size_t line = 1;
    for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', end + 1), line++) {
        try {
            (void)toml::parse(std::string_view(text).substr(0, end + 1));
        } catch (const toml::parse_error &) {
            continue; /* a value that goes on in the next line */
        } catch (const toml_check_failed &) {
            break;
        }
    }
    return line;
}

} // namespace

std::string place(const std::string &origin, const toml::source_region &source)
{
    return origin + ":" + std::to_string(source.begin.line);
}

[[noreturn]] void fail(const std::string &where, const rig_error &error)
{
    throw input_error(where, error.key, error.message);
}

std::string number_text(double value)
{
    char digits[32];
    const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
    return std::string(digits, end);
}

std::string text_of(const toml::node &value)
{
    std::ostringstream text;
    if (const auto *string = value.as_string()) {
        text << '"' << string->get() << '"';
    } else if (const auto *integer = value.as_integer()) {
        text << integer->get();
    } else if (const auto *number = value.as_floating_point()) {
        text << number_text(number->get());
    } else if (const auto *boolean = value.as_boolean()) {
        text << (boolean->get() ? "true" : "false");
    } else {
        text << value.type();
    }
    return text.str();
}

double finite_number(const std::string &key, const toml::node &node, const std::string &origin)
{
    const auto value = node.value<double>();
    if (!node.is_number() || !value || !std::isfinite(*value)) {
        fail(place(origin, node.source()), {key, "must be a finite number (is " + text_of(node) + ")"});
    }
    return *value;
}

void read_value(rig &rig, const std::string &path, const toml::node &value, const std::string &where)
{
    const rig_key *key = find_key(path);
    if (key != nullptr && !type_fits(*key, value)) {
        static const char *const expected[] = {"a number", "a whole number", "true or false", "a word in quotes",
                                               "text in quotes"};
        const bool is_quoted_number = value.is_string() && static_cast<int>(key->type) < 2;
        fail(where,
             {path, std::string("must be ") + expected[static_cast<int>(key->type)] + " (is " + text_of(value) +
                        ")" + (is_quoted_number ? "; write it without quotes and without its unit" : "")});
    }
    if (const auto error = set_value(rig, path, text_of(value))) {
        fail(where, *error);
    }
}

bool is_file_name(std::string_view name)
{
    constexpr std::size_t bytes_max = 100;
    return name.size() <= bytes_max && name.substr(0, 1) != "." && name.find('/') == std::string_view::npos &&
           std::none_of(name.begin(), name.end(), is_control);
}

std::string read_text(const std::string &key, const toml::node &value, const std::string &where)
{
    if (!value.is_string()) {
        fail(where, {key, "must be text in quotes"});
    }
    std::string text = value.as_string()->get();
    if (const auto error = text_error(text)) {
        fail(where, {key, *error});
    }
    return text;
}

std::string read_file_name(const std::string &key, const toml::node &value, const std::string &where)
{
    std::string name = read_text(key, value, where);
    if (!is_file_name(name)) {
        fail(where,
             {key, "names files: it must have at most 100 bytes, no \"/\" and no control characters, and must "
                   "not start with \".\""});
    }
    return name;
}

std::string stem_of(const std::string &path)
{
    const std::size_t slash = path.rfind('/');
    const std::string file = slash == std::string::npos ? path : path.substr(slash + 1);
    return file.substr(0, file.rfind('.'));
}

bool looks_like_path(const std::string &name_or_path)
{
    return name_or_path.find('/') != std::string::npos || name_or_path.find(".toml") != std::string::npos;
}

std::int64_t line_of_xml(const std::string &text)
{
    const std::size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string::npos || text[first] != '<') {
        return 0;
    }
    return 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(first), '\n');
}

toml::table parse_toml(const std::string &text, const std::string &origin)
{
    try {
        return toml::parse(text, origin);
    } catch (const toml::parse_error &error) {
        const std::string remedy = toml_remedy(text, error.source().begin.line, error.description());
        throw input_error(place(origin, error.source()) + ": " + std::string(error.description()) +
                          (remedy.empty() ? "" : "; " + remedy));
    } catch (const toml_check_failed &) {
        throw input_error(origin + ":" + std::to_string(line_of_failed_check(text)) + ": syntax error");
    }
}

} // namespace berth
