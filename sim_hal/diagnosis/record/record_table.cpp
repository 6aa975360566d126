#include "record_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <utility>

#include "../../../hal/rig/rig_file.h"
#include "record_lines.h"

namespace berth
{

namespace
{

std::string_view trimmed(std::string_view text)
{
    while (!text.empty() && (text.front() == ' ' || text.front() == '"' || text.front() == '\t')) {
        text.remove_prefix(1);
    }
    while (!text.empty() &&
           (text.back() == ' ' || text.back() == '\r' || text.back() == '"' || text.back() == '\t')) {
        text.remove_suffix(1);
    }
    return text;
}

std::string_view take_cell(std::string_view &line, bool &is_last)
{
    const std::size_t comma = line.find(',');
    is_last = comma == std::string_view::npos;
    const std::string_view cell = trimmed(line.substr(0, comma));
    line.remove_prefix(is_last ? line.size() : comma + 1);
    return cell;
}

/* Fit for a terminal: short, and nothing that it would obey. */
std::string printable(std::string_view text)
{
    std::string result(text.substr(0, 60));
    std::replace_if(
        result.begin(), result.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return result + (text.size() > 60 ? "..." : "");
}

double number(std::string_view cell, const std::string &path, long line, const std::string &column)
{
    double value = 0.0;
    if (cell.size() > 1 && cell.front() == '+') {
        cell.remove_prefix(1);
    }
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
        throw input_error(path + ":" + std::to_string(line) + ": " + column + ": \"" + printable(cell) +
                          "\" is not a finite number; leave out rows that were not measured");
    }
    return value;
}

} // namespace

void check_row_count(const std::string &path, std::size_t rows)
{
    if (rows > record_rows_max) {
        throw input_error(path + ": has more than " + std::to_string(record_rows_max) +
                          " rows, with which a diagnosis would take long and find no more; cut out a minute or two "
                          "in which the rig moves, of a CSV file with head and tail");
    }
}

const table_column *record_table::find(const std::string &name) const
{
    const auto found =
        std::find_if(columns.begin(), columns.end(), [&](const table_column &known) { return known.name == name; });
    return found == columns.end() ? nullptr : &*found;
}

std::string record_table::names() const
{
    std::string all;
    for (const table_column &column : columns) {
        all += (all.empty() ? "" : ", ") + printable(column.name);
    }
    return all;
}

namespace
{

/* A line that says something: neither empty nor a comment. */
bool next_row(record_lines &lines, std::string_view &line)
{
    while (lines.next(line)) {
        const std::string_view text = trimmed(line);
        if (!text.empty() && text.front() != '#') {
            return true;
        }
    }
    return false;
}

std::string place(const std::string &path, long line)
{
    return path + ":" + std::to_string(line) + ": ";
}

std::vector<bool> read_header(record_table &table, std::string_view line, const std::string &path,
                              const std::vector<std::string> &wanted)
{
    std::vector<bool> is_wanted;
    bool is_any_a_name = false;
    for (bool is_last = false; !is_last;) {
        const std::string_view cell = take_cell(line, is_last);
        const std::string name(cell);
        is_wanted.push_back(std::find(wanted.begin(), wanted.end(), name) != wanted.end());
        if (is_wanted.back() && table.find(name) != nullptr) {
            throw input_error(place(path, table.header_line) + "two columns are called " + printable(name) +
                              "; rename the one that is not meant");
        }
        double value = 0.0;
        const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
        is_any_a_name = is_any_a_name || error != std::errc() || end != cell.data() + cell.size();
        table.columns.push_back({name, {}});
    }
    const std::string &only = table.columns.front().name;
    for (const auto &[separator, called] : {std::pair(';', "semicolons"), {'\t', "tabs"}, {' ', "blanks"}}) {
        if (table.columns.size() == 1 && only.find(separator) != std::string::npos) {
            throw input_error(place(path, table.header_line) + "its columns are separated by " + called +
                              "; write commas, and points in the numbers");
        }
    }
    if (!is_any_a_name) {
        throw input_error(place(path, table.header_line) +
                          "has numbers and no names; the first line that is no comment (#) must name the columns");
    }
    return is_wanted;
}

/* Unsigned, as a char has a sign on amd64 and none on arm64: bytes from 0x80 on are letters of UTF-8. */
bool is_of_no_text(unsigned char letter)
{
    return letter < ' ' && letter != '\t' && letter != '\r';
}

} // namespace

record_table read_record_table(const std::string &path, const std::vector<std::string> &wanted)
{
    record_lines lines(path);
    record_table table;
    std::string_view line;
    bool is_there = lines.next(line);
    constexpr std::string_view byte_order_mark = "\xef\xbb\xbf"; /* spreadsheets write it */
    if (line.substr(0, byte_order_mark.size()) == byte_order_mark) {
        line.remove_prefix(byte_order_mark.size());
    }
    if (line.find('\0') != std::string_view::npos) { /* letters of two bytes or four, or no letters */
        throw input_error(place(path, lines.number()) +
                          "is no text of one byte a letter, UTF-16 perhaps; save it as UTF-8");
    }
    if (std::any_of(line.begin(), line.end(), is_of_no_text)) {
        throw input_error(place(path, lines.number()) + "is no text; a record is a CSV file or a log (.ulg)");
    }
    if (is_there && (trimmed(line).empty() || trimmed(line).front() == '#')) {
        is_there = next_row(lines, line);
    }
    if (!is_there) {
        throw input_error(path + ": is empty");
    }
    table.header_line = lines.number();
    const std::vector<bool> is_wanted = read_header(table, line, path, wanted);
    while (next_row(lines, line)) {
        check_row_count(path, table.lines.size() + 1);
        table.lines.push_back(static_cast<std::int32_t>(lines.number()));
        bool is_last = false;
        for (std::size_t i = 0; i < table.columns.size(); i++) {
            if (is_last) {
                throw input_error(place(path, lines.number()) + "has " + std::to_string(i) + " cells and not " +
                                  std::to_string(table.columns.size()) + " as the header");
            }
            const std::string_view cell = take_cell(line, is_last);
            if (is_wanted[i]) {
                table.columns[i].values.push_back(number(cell, path, lines.number(), table.columns[i].name));
            }
        }
        if (!is_last) {
            throw input_error(place(path, lines.number()) + "has more cells than the " +
                              std::to_string(table.columns.size()) +
                              " of the header; is there a comma too many, or one for a decimal point?");
        }
    }
    table.hash = lines.hash();
    return table;
}

} // namespace berth
