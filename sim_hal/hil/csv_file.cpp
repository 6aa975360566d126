#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../../hal/rig/rig_file.h"
#include "column_units.h"
#include "csv_cells.h"
#include "csv_reader.h"
#include "profile.h"

namespace berth
{

namespace
{

constexpr std::size_t profile_rows_max = 5000000; /* 100 MB in memory; hours of a motion */

/* By a name that says so, and not by one that stands beside a number, as in a preamble: "Time, 10:12". */
bool names_a_time(const std::vector<std::string_view> &cells)
{
    const bool is_plain =
        std::any_of(cells.begin(), cells.end(), [](std::string_view cell) { return is_column_called(cell, "t_s"); });
    return is_plain || (cells.size() > 1 && std::any_of(cells.begin(), cells.end(), is_name_of_time) &&
                        std::none_of(cells.begin(), cells.end(), [](std::string_view cell) {
                            return cell_number(cell, '.') || cell_stamp_s(cell);
                        }));
}

std::string header_place(const csv_reader &file)
{
    return file.header_line() == 0 ? "" : ":" + std::to_string(file.header_line()) + ": ";
}

std::size_t time_column(const csv_reader &file, const std::string &path)
{
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < file.columns().size(); i++) {
        if (is_column_called(file.columns()[i].name, "t_s")) {
            return i;
        }
        if (is_name_of_time(file.columns()[i].name)) {
            found.push_back(i);
        }
    }
    if (found.size() == 1) {
        return found.front();
    }
    throw input_error(path + header_place(file) +
                      (found.empty() ? "there is no column t_s" : "several columns are a time and none is t_s") +
                      "; the columns are " + file.names());
}

std::size_t value_column(const csv_reader &file, const std::string &path, const file_column &wanted,
                         std::size_t time)
{
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < file.columns().size(); i++) {
        const std::string &name = file.columns()[i].name;
        if (wanted.name.empty() ? i != time && !name.empty() : is_column_called(name, wanted.name)) {
            found.push_back(i);
        }
    }
    if (found.size() == 1) {
        return found.front();
    }
    if (!wanted.name.empty()) {
        throw input_error(path + header_place(file) +
                          (found.empty() ? "there is no column " : "several columns are called ") + wanted.name +
                          "; the columns are " + file.names());
    }
    throw input_error(path + header_place(file) + "has " + std::to_string(found.size()) +
                      " columns beside the time (" + file.names() + "); name one with " + wanted.name_key);
}

std::string unit_place(const csv_reader &file, const std::string &path, bool is_of_row)
{
    return path + ":" + std::to_string(is_of_row ? file.unit_line() : file.header_line()) + ": ";
}

/* What makes seconds of the column's numbers; nothing: it says no unit. */
std::optional<double> seconds_a_number(const csv_reader &file, const csv_column &column, const std::string &path)
{
    const auto other = unit_other_than("s", column.name, column.row_unit);
    if (!other) {
        const bool says_s = !column.row_unit.empty() || !split_column_name(column.name).unit.empty();
        return says_s ? std::optional(1.0) : std::nullopt;
    }
    if (!other->factor || (other->is_of_row && !split_column_name(column.name).unit.empty())) {
        throw input_error(unit_place(file, path, other->is_of_row) + printable_cell(column.name) + " is in " +
                          printable_cell(other->text) + " here, which is not the unit of its name or no time");
    }
    return other->factor;
}

/* A unit that is not the one wanted, where no scale converts it. */
void refuse_other_unit(const csv_reader &file, const csv_column &column, const std::string &path,
                       const file_column &wanted)
{
    const auto other = unit_other_than(wanted.si, column.name, column.row_unit);
    if (!other || std::abs(wanted.scale) != 1.0) {
        return;
    }
    char scale[40] = "...";
    if (other->factor) {
        std::snprintf(scale, sizeof scale, "%.10g", *other->factor);
    }
    throw input_error(unit_place(file, path, other->is_of_row) + printable_cell(column.name) + " is in " +
                      printable_cell(other->text) + ", and what is played in " + std::string(wanted.si) +
                      (other->factor ? "; convert it: "
                                     : ", which is something else; name another column with " + wanted.name_key +
                                           ", or convert it: ") +
                      wanted.scale_key + "=" + scale);
}

} // namespace

csv_columns read_csv_columns(const std::string &path, const file_column &wanted)
{
    csv_reader file(path, names_a_time);
    const std::size_t time_at = time_column(file, path);
    const csv_column &time = file.columns()[time_at];
    const auto second = seconds_a_number(file, time, path);
    const std::size_t value_at = value_column(file, path, wanted, time_at);
    const csv_column &value = file.columns()[value_at];
    refuse_other_unit(file, value, path, wanted);

    csv_columns read;
    if (value.row_unit.empty() && split_column_name(value.name).unit.empty() && wanted.scale == 1.0) {
        read.note = path + header_place(file) + "the column " + printable_cell(value.name) +
                    " names no unit; its values count as " + std::string(wanted.si) + ", times " + wanted.scale_key +
                    " = 1";
    }
    while (file.next()) {
        const std::string where = path + ":" + std::to_string(file.line()) + ": ";
        if (read.times_s.size() >= profile_rows_max) {
            throw input_error(where + "is beyond row " + std::to_string(profile_rows_max) +
                              ", the last one that is read; give a part of the file, or fewer rows a second");
        }
        const auto stamp_s = file.stamp_s(time_at);
        if (!stamp_s && !second) {
            throw input_error(where + "the column " + printable_cell(time.name) +
                              " names no unit; call it t_s if it is in seconds");
        }
        const double time_s = stamp_s ? *stamp_s : *second * file.number(time_at);
        if (!read.times_s.empty() && time_s <= read.times_s.back()) {
            throw input_error(where + printable_cell(time.name) + " does not increase");
        }
        read.times_s.push_back(time_s);
        read.values.push_back(file.number(value_at));
        read.lines.push_back(static_cast<int>(file.line()));
    }
    if (read.times_s.size() < 2) {
        throw input_error(path + ": needs at least two rows");
    }
    return read;
}

} // namespace berth
