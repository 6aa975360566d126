#include "csv_cells.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace berth
{

namespace
{

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Reads up to `digits_max` digits, at least one, from the front of `text`. */
std::optional<int> take_digits(std::string_view &text, int digits_max)
{
    int value = 0;
    int digits = 0;
    while (digits < digits_max && !text.empty() && is_digit(text.front())) {
        value = 10 * value + (text.front() - '0');
        text.remove_prefix(1);
        digits++;
    }
    return digits > 0 ? std::optional(value) : std::nullopt;
}

bool take(std::string_view &text, std::string_view any_of)
{
    const bool is_there = !text.empty() && any_of.find(text.front()) != std::string_view::npos;
    text.remove_prefix(is_there ? 1 : 0);
    return is_there;
}

/* Days from 1970-01-01 in the Gregorian calendar: years begin in March, so that a leap day is the last one. */
long days_since_1970(int year, int month, int day)
{
    const long y = month > 2 ? year : year - 1;
    const long shifted_month = (month + 9) % 12;
    constexpr long days_until_1970 = 719468; /* from 0000-03-01 */
    return 365 * y + y / 4 - y / 100 + y / 400 + (153 * shifted_month + 2) / 5 + day - 1 - days_until_1970;
}

std::optional<double> take_clock_s(std::string_view &text)
{
    const auto hours = take_digits(text, 2);
    if (!hours || !take(text, ":")) {
        return std::nullopt;
    }
    const auto minutes = take_digits(text, 2);
    if (!minutes || !take(text, ":")) {
        return std::nullopt;
    }
    const auto seconds = take_digits(text, 2);
    if (!seconds || *hours > 24 || *minutes > 59 || *seconds > 60) {
        return std::nullopt;
    }
    double fraction_s = 0.0;
    if (take(text, ".,")) {
        std::string decimals = "0.";
        while (!text.empty() && is_digit(text.front())) {
            decimals += text.front();
            text.remove_prefix(1);
        }
        std::from_chars(decimals.data(), decimals.data() + decimals.size(), fraction_s);
    }
    return 3600.0 * *hours + 60.0 * *minutes + *seconds + fraction_s;
}

/* Z, +01:00, +0100, +01 or nothing, and the end. */
std::optional<double> take_zone_s(std::string_view &text)
{
    take(text, " ");
    if (text.empty() || text == "Z" || text == "z" || text == "UTC") {
        return 0.0;
    }
    const double sign = text.front() == '-' ? -1.0 : 1.0;
    if (!take(text, "+-")) {
        return std::nullopt;
    }
    const auto hours = take_digits(text, 2);
    take(text, ":");
    const int minutes = take_digits(text, 2).value_or(0);
    return hours && text.empty() ? std::optional(sign * (3600.0 * *hours + 60.0 * minutes)) : std::nullopt;
}

std::string_view without_blanks_about(std::string_view text)
{
    constexpr std::string_view blanks = " \t\r";
    const std::size_t from = std::min(text.find_first_not_of(blanks), text.size());
    return text.substr(from, text.find_last_not_of(blanks) + 1 - from);
}

/* `at` is behind the opening quote; moves it behind the closing one. False: there is none. */
bool take_quoted(std::string_view row, std::size_t &at, std::string_view &cell, std::vector<std::string> &unquoted)
{
    const std::size_t begin = at;
    bool has_quotes = false;
    for (; at < row.size(); at++) {
        if (row[at] != '"') {
            continue;
        }
        if (at + 1 < row.size() && row[at + 1] == '"') {
            has_quotes = true;
            at++;
            continue;
        }
        cell = row.substr(begin, at - begin);
        at++;
        if (has_quotes) {
            std::string text;
            for (std::size_t i = 0; i < cell.size(); i++) {
                text += cell[i];
                i += cell[i] == '"';
            }
            unquoted.push_back(std::move(text));
            cell = {};
        }
        return true;
    }
    return false;
}

} // namespace

bool split_cells(std::string_view row, char delimiter, std::vector<std::string_view> &cells,
                 std::vector<std::string> &unquoted)
{
    cells.clear();
    unquoted.clear();
    std::vector<std::size_t> places; /* of those in `unquoted`, which may still move */
    for (std::size_t at = 0;;) {
        const std::size_t begin = std::min(row.find_first_not_of(delimiter == '\t' ? " " : " \t", at), row.size());
        std::string_view cell;
        if (begin < row.size() && row[begin] == '"') {
            at = begin + 1;
            const std::size_t known = unquoted.size();
            if (!take_quoted(row, at, cell, unquoted)) {
                return false;
            }
            if (unquoted.size() > known) {
                places.push_back(cells.size());
            }
            cell = without_blanks_about(cell);
            at = row.find(delimiter, at);
        } else {
            at = row.find(delimiter, at);
            cell = begin < std::min(at, row.size())
                       ? without_blanks_about(row.substr(begin, std::min(at, row.size()) - begin))
                       : std::string_view{};
        }
        cells.push_back(cell);
        if (at == std::string_view::npos) {
            break;
        }
        at++;
    }
    for (std::size_t i = 0; i < places.size(); i++) {
        cells[places[i]] = unquoted[i];
    }
    return true;
}

std::optional<double> cell_number(std::string_view cell, char mark)
{
    constexpr std::size_t digits_max = 400; /* a double written out has fewer */
    if (cell.size() > 1 && cell.front() == '+') {
        cell.remove_prefix(1);
    }
    char copy[digits_max];
    const std::size_t exponent = cell.find_first_of("dD");
    const bool is_other = exponent != std::string_view::npos || cell.find(',') != std::string_view::npos;
    if (is_other) {
        if (cell.size() > digits_max || (mark == ',' && cell.find('.') != std::string_view::npos)) {
            return std::nullopt;
        }
        std::copy(cell.begin(), cell.end(), copy);
        if (exponent != std::string_view::npos) {
            copy[exponent] = 'e';
        }
        if (mark == ',') {
            const std::size_t comma = cell.find(',');
            if (comma != std::string_view::npos) {
                copy[comma] = '.';
            }
        }
        cell = std::string_view(copy, cell.size());
    }
    double value = 0.0;
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    const bool is_number = error == std::errc() && end == cell.data() + cell.size() && std::isfinite(value);
    return is_number ? std::optional(value) : std::nullopt;
}

std::optional<double> cell_stamp_s(std::string_view cell)
{
    std::string_view text = cell;
    const auto clock_s = take_clock_s(text);
    if (clock_s) {
        return text.empty() ? clock_s : std::nullopt;
    }
    text = cell;
    const auto year = take_digits(text, 4);
    if (!year || *year < 1000 || !take(text, "-")) {
        return std::nullopt;
    }
    const auto month = take_digits(text, 2);
    if (!month || *month < 1 || *month > 12 || !take(text, "-")) {
        return std::nullopt;
    }
    const auto day = take_digits(text, 2);
    if (!day || *day < 1 || *day > 31 || !take(text, "T t")) {
        return std::nullopt;
    }
    const auto of_day_s = take_clock_s(text);
    const auto zone_s = of_day_s ? take_zone_s(text) : std::nullopt;
    if (!zone_s) {
        return std::nullopt;
    }
    return 86400.0 * static_cast<double>(days_since_1970(*year, *month, *day)) + *of_day_s - *zone_s;
}

std::string wrong_cell(std::string_view cell)
{
    const auto said = [&](const char *why) { return "\"" + printable_cell(cell) + "\" " + why; };
    if (cell.empty()) {
        return "the cell is empty and no finite number; leave out rows that were not measured";
    }
    if (cell_stamp_s(cell)) {
        return said("is a date or a clock time and no number; is another column meant?");
    }
    const auto digits = std::count_if(cell.begin(), cell.end(), is_digit);
    const auto marks =
        std::count_if(cell.begin(), cell.end(), [](char c) { return c == '/' || c == ':' || c == '-'; });
    if (digits >= 4 && marks >= 2) {
        return said("is not a finite number; write a date as 2026-03-04T10:11:12.0025, or seconds");
    }
    if (cell.find_first_of(",'") != std::string_view::npos && digits > 0) {
        return said("is not a finite number; write numbers without marks between the thousands");
    }
    return said("is not a finite number; leave out rows that were not measured");
}

std::string printable_cell(std::string_view text)
{
    constexpr std::size_t longest = 60;
    std::string result(text.substr(0, longest));
    std::replace_if(
        result.begin(), result.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return result + (text.size() > longest ? "..." : "");
}

} // namespace berth
