#include "csv_reader.h"

#include <algorithm>
#include <utility>

#include "../../hal/rig/rig_file.h"
#include "column_units.h"
#include "csv_cells.h"

namespace berth
{

namespace
{

constexpr char delimiters[] = {',', ';', '\t'};
constexpr std::size_t preamble_rows_max = 100;
constexpr std::size_t row_bytes_max = 1u << 20; /* of several lines, held together by quotes */

/* Unsigned, as a char has a sign on amd64 and none on arm64: bytes from 0x80 on are letters of UTF-8. */
bool is_of_no_text(unsigned char letter)
{
    return letter < ' ' && letter != '\t' && letter != '\r';
}

bool is_number_or_stamp(std::string_view cell)
{
    return cell_number(cell, '.') || cell_number(cell, ',') || cell_stamp_s(cell);
}

bool are_numbers(const std::vector<std::string_view> &cells)
{
    return std::all_of(cells.begin(), cells.end(),
                       [](std::string_view cell) { return cell.empty() || is_number_or_stamp(cell); });
}

/* Nothing but units, which some cells may lack: at least one is known, and none is a number. */
bool are_units(const std::vector<std::string_view> &cells)
{
    return std::none_of(cells.begin(), cells.end(), is_number_or_stamp) &&
           std::any_of(cells.begin(), cells.end(), [](std::string_view cell) { return find_unit(cell) != nullptr; });
}

bool says_nothing(std::string_view row)
{
    const std::size_t first = row.find_first_not_of(" \t\r,;");
    return first == std::string_view::npos || row[first] == '#' || row[first] == '%';
}

/* 1,234 may be a thousand and more; 0,234 and 1,23 and 1,234e3 may not. */
bool is_decimal_comma(std::string_view cell)
{
    const std::size_t comma = cell.find(',');
    std::string_view whole = cell.substr(0, comma);
    whole.remove_prefix(!whole.empty() && (whole.front() == '-' || whole.front() == '+') ? 1 : 0);
    constexpr std::size_t group = 3;
    return whole.empty() || whole.front() == '0' || whole.size() > group || cell.size() != comma + 1 + group;
}

} // namespace

bool is_column_called(std::string_view column, std::string_view name)
{
    return column == name || plain_column_name(column) == name;
}

csv_reader::csv_reader(const std::string &path, const names_test &has_names) : path_(path), lines_(path)
{
    find_header(has_names);
    take_header();
    take_units();
}

std::string csv_reader::names() const
{
    std::string all;
    for (const csv_column &column : columns_) {
        all += (all.empty() ? "" : ", ") + printable_cell(column.name);
    }
    return all;
}

void csv_reader::refuse(const std::string &what) const
{
    throw input_error(path_ + ":" + std::to_string(line_) + ": " + what);
}

/* A line that says something: neither empty nor a comment. */
bool csv_reader::next_row(std::string_view &row)
{
    if (!kept_.empty()) {
        row_ = std::move(kept_.front().text);
        line_ = kept_.front().line;
        kept_.pop_front();
        row = row_;
        return true;
    }
    while (lines_.next(row)) {
        line_ = lines_.number();
        if (line_ == 1 && row.substr(0, 4) == "PK\x03\x04") {
            refuse("is a spreadsheet or an archive; save it as CSV");
        }
        if (line_ == 1 && row.find('\0') != std::string_view::npos) { /* letters of four bytes, or no letters */
            refuse("is no text of one byte a letter or UTF-16; save it as UTF-8");
        }
        if (line_ == 1 && std::any_of(row.begin(), row.end(), is_of_no_text)) {
            refuse("is no text; give a CSV file, or as a record a CSV file or a log (.ulg)");
        }
        if (!says_nothing(row)) {
            return true;
        }
    }
    return false;
}

/* Further lines are taken in while a quote is open. False: it is never closed. */
bool csv_reader::split_whole(std::string_view row, char delimiter)
{
    if (split_cells(row, delimiter, cells_, unquoted_)) {
        return true;
    }
    if (row.data() != row_.data()) {
        row_ = row;
    }
    std::string_view more;
    while (row_.size() < row_bytes_max && lines_.next(more)) {
        row_.append("\n").append(more);
        if (more.find('"') != std::string_view::npos && split_cells(row_, delimiter, cells_, unquoted_)) {
            return true;
        }
    }
    return false;
}

/* Leaves the header and what was read behind it in `kept_`. */
void csv_reader::find_header(const names_test &has_names)
{
    std::deque<kept_row> rows;
    std::string_view row;
    std::size_t header = 0;
    bool is_found = false;
    while (!is_found && rows.size() < preamble_rows_max && next_row(row)) {
        rows.push_back({std::string(row), line_});
        std::size_t most = 0;
        bool has_numbers = false;
        for (const char delimiter : delimiters) {
            if (!split_cells(rows.back().text, delimiter, cells_, unquoted_)) {
                continue;
            }
            has_numbers = has_numbers || (cells_.size() > 1 && are_numbers(cells_));
            if (cells_.size() > most && has_names(cells_)) {
                most = cells_.size();
                delimiter_ = delimiter;
                is_found = true;
            }
        }
        header = is_found ? rows.size() - 1 : header;
        if (!is_found && has_numbers) { /* the names are above, and none of them is known */
            header = rows.size() > 1 ? rows.size() - 2 : 0;
            break;
        }
    }
    if (rows.empty()) {
        throw input_error(path_ + ": is empty");
    }
    if (!is_found) {
        std::size_t most = 0;
        for (const char delimiter : delimiters) {
            if (split_cells(rows[header].text, delimiter, cells_, unquoted_) && cells_.size() > most) {
                most = cells_.size();
                delimiter_ = delimiter;
            }
        }
        split_cells(rows[header].text, delimiter_, cells_, unquoted_);
        header -= header > 0 && are_units(cells_);
    }
    rows.erase(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(header));
    kept_ = std::move(rows);
}

void csv_reader::take_header()
{
    std::string_view row;
    next_row(row);
    header_line_ = line_;
    if (!split_whole(row, delimiter_)) {
        refuse("a quote (\") is opened and never closed; close it, or name a CSV file");
    }
    for (const std::string_view cell : cells_) {
        columns_.push_back({std::string(cell), {}});
    }
    if (columns_.size() == 1 && columns_[0].name.find_first_of("=[") != std::string::npos) {
        refuse("is TOML, as a rig file is, and no table; a rig file goes behind --rig, or stands as RIG");
    }
    if (columns_.size() == 1 && columns_[0].name.find(' ') != std::string::npos) {
        refuse("its columns are separated by blanks; write commas, semicolons or tabs");
    }
    if (are_numbers(cells_)) {
        refuse(
            "has numbers and no names; a line above the numbers that is no comment (# or %) must name the columns");
    }
}

void csv_reader::take_units()
{
    std::string_view row;
    if (!next_row(row)) {
        return;
    }
    kept_row first{std::string(row), line_};
    const bool is_whole = split_cells(first.text, delimiter_, cells_, unquoted_);
    if (!is_whole || cells_.size() > columns_.size() || !are_units(cells_)) {
        kept_.push_front(std::move(first));
        return;
    }
    unit_line_ = line_;
    for (std::size_t i = 0; i < cells_.size(); i++) {
        const bool says_none = cells_[i] == "-" || cells_[i] == "[-]" || cells_[i] == "(-)";
        columns_[i].row_unit = says_none ? std::string_view{} : cells_[i];
    }
}

bool csv_reader::next()
{
    std::string_view row;
    if (!next_row(row)) {
        if (mark_ == ',' && !is_comma_certain_) {
            refuse("the comma in its numbers may stand before decimals or between thousands; write points before "
                   "decimals, and nothing between thousands");
        }
        return false;
    }
    if (!split_whole(row, delimiter_)) {
        refuse("a quote (\") is opened and never closed; close it, or name a CSV file");
    }
    while (cells_.size() > columns_.size() && cells_.back().empty()) {
        cells_.pop_back();
    }
    if (cells_.size() > columns_.size()) {
        refuse("has more cells than the " + std::to_string(columns_.size()) +
               " of the header; is there a comma too many, or one for a decimal point?");
    }
    while (cells_.size() < columns_.size() && columns_[cells_.size()].name.empty()) {
        cells_.emplace_back();
    }
    if (cells_.size() < columns_.size()) {
        refuse("has " + std::to_string(cells_.size()) + " cells, too few: the header has " +
               std::to_string(columns_.size()));
    }
    return true;
}

/* Decimals have one mark throughout: a second one would stand between thousands. */
void csv_reader::check_mark(std::string_view cell)
{
    const bool has_comma = cell.find(',') != std::string_view::npos;
    const bool has_point = cell.find('.') != std::string_view::npos;
    if (has_comma == has_point) {
        return; /* neither; or both, which is no number */
    }
    const char mark = has_comma ? ',' : '.';
    if (mark_ != '\0' && mark_ != mark) {
        refuse("\"" + printable_cell(cell) + "\" has a " + (has_comma ? "comma" : "point") +
               " where others have a " + (has_comma ? "point" : "comma") +
               "; write one of them before decimals, and nothing between thousands");
    }
    mark_ = mark;
    is_comma_certain_ = is_comma_certain_ || (has_comma && is_decimal_comma(cell));
}

std::optional<double> csv_reader::stamp_s(std::size_t column) const
{
    return cell_stamp_s(cells_[column]);
}

double csv_reader::number(std::size_t column)
{
    const std::string_view cell = cells_[column];
    const bool has_comma = cell.find(',') != std::string_view::npos;
    const auto value = cell_number(cell, has_comma ? ',' : '.');
    if (!value) {
        refuse(printable_cell(columns_[column].name) + ": " + wrong_cell(cell));
    }
    check_mark(cell);
    return *value;
}

} // namespace berth
