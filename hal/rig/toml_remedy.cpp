#include "toml_remedy.h"

#include <algorithm>
#include <cctype>

namespace berth
{

namespace
{

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

bool is_letter(char c)
{
    return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool is_ascii(std::string_view text)
{
    return std::all_of(text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

std::string_view trimmed(std::string_view text)
{
    const std::size_t from = text.find_first_not_of(" \t\r");
    return from == std::string_view::npos ? std::string_view()
                                          : text.substr(from, text.find_last_not_of(" \t\r") + 1 - from);
}

std::string_view line_of(std::string_view text, std::size_t line)
{
    for (; line > 1; line--) {
        const std::size_t end = text.find('\n');
        text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    return trimmed(text.substr(0, text.find('\n')));
}

bool starts_with(std::string_view text, std::string_view start)
{
    return text.substr(0, start.size()) == start;
}

std::string_view leading_digits(std::string_view text)
{
    return text.substr(
        0, static_cast<std::size_t>(std::find_if_not(text.begin(), text.end(), is_digit) - text.begin()));
}

std::string lower_case(std::string_view text)
{
    std::string lower(text);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return lower;
}

/* Of a word without quotes. */
std::string word_remedy(std::string_view value)
{
    const std::string word = lower_case(value.substr(0, value.find_first_of(" \t#;,")));
    if (word == "true" || word == "yes" || word == "on") {
        return "write true, in small letters";
    }
    if (word == "false" || word == "no" || word == "off") {
        return "write false, in small letters";
    }
    return "put words in quotes, as \"linear\"";
}

std::string value_remedy(std::string_view value)
{
    if (value.empty()) {
        return "write a value behind the =";
    }
    if (value.front() == '=') {
        return "write one = alone";
    }
    for (const std::string_view quote : {"\u201c", "\u201d", "\u201e", "\u2018", "\u2019", "\u00ab", "`"}) {
        if (starts_with(value, quote)) {
            return "use straight quotes, as \"linear\"";
        }
    }
    if (is_letter(value.front())) {
        return word_remedy(value);
    }
    if (const std::size_t end = value.find_last_of("\"'");
        value.find(';', end == std::string_view::npos ? 0 : end) != std::string_view::npos) {
        return "leave out the semicolon: a line ends without one, and # starts a comment";
    }
    return number_remedy(value);
}

/* Of a section, or of a key: before its =. */
std::string_view name_in(std::string_view line)
{
    return trimmed(starts_with(line, "[") ? line.substr(0, line.find(']')) : line.substr(0, line.find('=')));
}

/* Where the section, or the key within its section, of a line stands first. */
std::string stated_before(std::string_view text, std::size_t line)
{
    const std::string_view name = name_in(line_of(text, line));
    const bool is_section = starts_with(name, "[");
    std::size_t first = 0;
    for (std::size_t i = 1; i < line; i++) {
        const std::string_view above = line_of(text, i);
        if (!is_section && starts_with(above, "[")) {
            first = 0; /* another section */
        }
        if (first == 0 && name_in(above) == name) {
            first = i;
        }
    }
    const std::string where = first == 0 ? "before" : "in line " + std::to_string(first);
    return "it stands " + where +
           " already: " + (is_section ? "put all of its keys under that one" : "leave one of the two out");
}

bool has_open_quote(std::string_view line)
{
    return std::count(line.begin(), line.end(), '"') % 2 == 1 || std::count(line.begin(), line.end(), '\'') % 2 == 1;
}

} // namespace

std::string number_remedy(std::string_view value)
{
    const std::string sign = starts_with(value, "-") ? "-" : "";
    std::string_view rest = value.substr(starts_with(value, "-") || starts_with(value, "+") ? 1 : 0);
    const std::string whole(leading_digits(rest));
    rest.remove_prefix(whole.size());
    if (whole.empty()) {
        return starts_with(rest, ".")
                   ? "write a digit before the point, as " + sign + "0" + std::string(trimmed(rest))
                   : "";
    }
    if (starts_with(rest, ",")) {
        const std::string decimals(leading_digits(rest.substr(1)));
        return "a point stands before decimals: " + sign + whole + "." + decimals +
               (decimals.size() == 3 ? ", and nothing between thousands: " + sign + whole + decimals : "");
    }
    if (starts_with(rest, "'")) {
        return "leave out what separates thousands, or write _";
    }
    if (starts_with(rest, ".")) {
        rest.remove_prefix(1);
        rest.remove_prefix(leading_digits(rest).size());
    }
    const std::string_view behind = trimmed(rest);
    if (!behind.empty() && std::string_view("*/+-^(").find(behind.front()) != std::string_view::npos) {
        return "write the result: nothing is calculated here";
    }
    const bool has_exponent = behind.size() > 1 && (behind[0] == 'e' || behind[0] == 'E') &&
                              (is_digit(behind[1]) || behind[1] == '-' || behind[1] == '+');
    const bool has_unit = !behind.empty() && !has_exponent && behind.front() != '#' &&
                          (is_letter(behind.front()) || behind.front() == '%' || behind.front() == '\xc2');
    return has_unit ? "leave the unit out: the key's name has it" : "";
}

std::string toml_remedy(std::string_view text, std::size_t line, std::string_view problem)
{
    if (problem.find("utf-8") != std::string_view::npos || problem.find("UTF-8") != std::string_view::npos) {
        return "save the file as UTF-8 text";
    }
    const std::string_view wrong = line_of(text, line);
    if (problem.find("redefine existing") != std::string_view::npos) {
        return stated_before(text, line);
    }
    if (problem.find("while parsing string") != std::string_view::npos && has_open_quote(wrong)) {
        return "a text ends with a quote: put \" behind it";
    }
    if (starts_with(trimmed(text), "{")) {
        return "this is JSON; write TOML: [loop] in one line, rate_Hz = 500 in the next";
    }
    if (starts_with(wrong, ";") || starts_with(wrong, "//")) {
        return "a comment starts with #";
    }
    const std::size_t equals = wrong.find('=');
    if (!is_ascii(wrong.substr(0, std::min(equals, wrong.find_first_of("\"'#"))))) {
        return "write keys and sections in the letters a to z; texts in quotes may have any";
    }
    const bool has_equals =
        equals != std::string_view::npos && problem.find("expected '='") == std::string_view::npos;
    if (has_equals) {
        return value_remedy(trimmed(wrong.substr(equals + 1)));
    }
    if (starts_with(wrong, "[")) {
        return wrong.find(']') == std::string_view::npos ? "close the section's name, as [robot]" : "";
    }
    return wrong.find(':') == std::string_view::npos
               ? "write key = value"
               : "write key = value, and a section as [robot]: this is TOML, and no YAML";
}

} // namespace berth
