#include "record_columns.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <functional>

#include "../../../hal/rig/rig_file.h"
#include "../../hil/column_units.h"
#include "../../hil/csv_cells.h"
#include "../formatted.h"
#include "../replay/block_model.h"

namespace berth
{

namespace
{

std::string shortly(double value)
{
    char text[40];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

std::string line_of(const std::string &path, long line)
{
    return path + ":" + std::to_string(line) + ": ";
}

std::string in_small_letters(std::string name)
{
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    return name;
}

/* Without the unit and what stands before it. */
std::string bare_name(const signal_member &signal)
{
    return in_small_letters(std::string(signal.name.substr(0, signal.name.size() - signal.unit.size() - 1)));
}

/* Columns that may be meant for a signal that is not there: the same name up to the unit, or without one, in small
 * letters or large ones; for t_s any name of a time. A column that is another signal's is not meant. */
std::vector<std::string> columns_like(const record_table &table, const signal_member &signal, const rig &rig)
{
    const std::string bare = bare_name(signal);
    std::vector<std::string> like;
    for (const table_column &column : table.columns) {
        const bool is_other =
            std::any_of(std::begin(signal_members), std::end(signal_members), [&](const signal_member &known) {
                return known.name == column.name || source_of(rig, known.name).column == column.name;
            });
        const std::string small = in_small_letters(column.name);
        const bool is_alike = small == bare || small.compare(0, bare.size() + 1, bare + "_") == 0 ||
                              in_small_letters(std::string(split_column_name(column.name).bare)) == bare ||
                              (signal.name == "t_s" && is_name_of_time(column.name));
        if (!is_other && is_alike) {
            like.push_back(column.name);
        }
    }
    return like;
}

bool has_unit(const std::string &column, std::string_view unit)
{
    return !split_column_name(column).unit.empty() && !unit_other_than(unit, column, {});
}

std::string that_has_another_unit(const std::string &column, const signal_member &signal,
                                  const std::string &row_unit)
{
    const auto other = unit_other_than(signal.unit, column, row_unit);
    const std::string name(signal.name);
    return column + " has another unit than " + name +
           (other && !other->text.empty() ? " (" + printable_cell(other->text) + ")" : "") +
           "; say in the rig file [signals] " + name + " = { column = \"" + column +
           "\", scale = " + (other && other->factor ? formatted("%.9g", *other->factor) : "...") + " }";
}

/* A scale converts; without one, the unit of the name and of the row below it must be the signal's. A rig file that
 * names the column may take an angle for a way. */
void refuse_other_unit(record &made, const record_table &table, const signal_member &signal,
                       const signal_source &source, const table_column &column)
{
    const auto other = unit_other_than(signal.unit, column.name, column.row_unit);
    if (!other || std::abs(source.scale) != 1.0) {
        return;
    }
    if (source.column != signal.name && is_rotary_counterpart(signal.unit, other->text)) {
        made.notes.push_back(source.column + " is read as " + source.signal + ", as the rig file says: 1 " +
                             printable_cell(other->text) + " counts as 1 " + std::string(signal.unit));
    } else {
        const std::string &path = made.path;
        throw input_error(line_of(path, other->is_of_row ? table.unit_line : table.header_line) +
                          that_has_another_unit(column.name, signal, column.row_unit));
    }
}

std::string that_may_be_meant(const std::string &column, const std::string &name)
{
    return "there is no column " + name + "; if " + column + " is meant, say in the rig file [signals] " + name +
           " = \"" + column + "\"";
}

/* A column with the right name but another unit is a mistake that would pass unseen. One with the right unit and
 * more of a name, or without a unit, may be meant, or may not: told. */
std::string judge_absent(const record_table &table, const std::string &path, const signal_member &signal,
                         const rig &rig)
{
    const std::string name(signal.name);
    const std::vector<std::string> like = columns_like(table, signal, rig);
    for (const std::string &column : like) {
        const bool has_none = in_small_letters(column) == bare_name(signal) || is_name_of_time(column);
        const bool is_time_in_another = is_name_of_time(column) && unit_other_than("s", column, {});
        if ((!has_unit(column, signal.unit) && !has_none) || is_time_in_another) {
            throw input_error(line_of(path, table.header_line) + that_has_another_unit(column, signal, {}));
        }
    }
    return like.empty() ? "" : that_may_be_meant(like.front(), name);
}

std::string that_is_left_out(const std::string &name, const std::string &column)
{
    return name + " is read from the column " + column + ", as the rig file says; the column " + name +
           " is left out";
}

/* A damaged cell would outweigh all others. */
void refuse_absurd(const std::vector<double> &values, const record_table &table, const std::string &path,
                   const signal_source &source, bool is_time)
{
    constexpr double beyond_any_rig = 1e12; /* once scaled to SI units; a clock's seconds since 1970 are 2e9 */
    constexpr double beyond_the_rest = 1e6;
    constexpr std::size_t damaged_max = 10; /* what more cells have is no damage but a unit */
    const auto size = [](double a, double b) { return std::abs(a) < std::abs(b); };
    const auto largest = std::max_element(values.begin(), values.end(), size);
    if (largest == values.end()) {
        return;
    }
    double rest = unlimited;
    if (!is_time && values.size() > damaged_max) {
        std::vector<double> sorted = values;
        const auto tenth = sorted.begin() + damaged_max;
        std::nth_element(sorted.begin(), tenth, sorted.end(), [&](double a, double b) { return size(b, a); });
        rest = std::abs(*tenth);
    }
    const double since_1970 = std::abs(*largest);
    for (const double scale : {1e-3, 1e-6, 1e-9}) {
        constexpr double earliest_s = 1e9, latest_s = 4.1e9; /* 2001 to 2099 */
        if (is_time && source.scale == 1.0 && since_1970 * scale > earliest_s && since_1970 * scale < latest_s) {
            throw input_error(line_of(path, table.header_line) + source.column + " has " + shortly(*largest) +
                              ", a time since 1970 in another unit than s; say in the rig file [signals] t_s = { "
                              "column = \"" +
                              source.column + "\", scale = " + shortly(scale) + " }");
        }
    }
    const bool is_lone = rest > 0.0 && std::abs(*largest) > beyond_the_rest * rest;
    if (is_lone || std::abs(source.scale * *largest) > beyond_any_rig) {
        const auto row = static_cast<std::size_t>(largest - values.begin());
        throw input_error(line_of(path, table.lines[row]) + source.column + ": " + shortly(*largest) +
                          (is_lone
                               ? " is beyond all that the rest of its column has, which is up to " + shortly(rest)
                               : " is beyond what any rig does") +
                          "; is the cell damaged? leave its row out");
    }
}

/* In a column that is there. */
bool is_still(const std::vector<double> &values)
{
    return !values.empty() &&
           std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end();
}

std::string that_is_still(const record &made, const signal_member &signal)
{
    return std::string(signal.name) + " is " + shortly((made.*signal.member).front()) + " in every row; ";
}

/* Two signals of one column would explain each other. */
void refuse_twice(const rig &rig, const record_table &table, const std::string &path, const signal_source &source)
{
    for (const signal_member &other : signal_members) {
        if (other.name != source.signal && source_of(rig, other.name).column == source.column) {
            throw input_error(line_of(path, table.header_line) + "[signals] reads " + source.signal + " and " +
                              std::string(other.name) + " from one column, " + source.column +
                              ": name the column of each");
        }
    }
}

} // namespace

signal_source source_of(const rig &rig, std::string_view signal)
{
    for (const signal_source &source : rig.signals) {
        if (source.signal == signal) {
            return source;
        }
    }
    return {std::string(signal), std::string(signal), 1.0, 0.0};
}

std::string mapping_of(const signal_source &source)
{
    return "[signals] " + source.signal + " = { column = \"" + source.column +
           "\", scale = " + formatted("%.9g", source.scale) +
           (source.offset == 0.0 ? "" : ", offset = " + formatted("%.9g", source.offset)) + " }";
}

void take_columns(record &made, const record_table &table, const rig &rig)
{
    std::vector<std::string> hints;
    for (const signal_member &signal : signal_members) {
        const std::string name(signal.name);
        const signal_source source = source_of(rig, signal.name);
        const table_column *const column = table.find(source.column);
        const bool is_mapped = source.column != signal.name;
        if (column == nullptr) {
            const std::string hint = is_mapped ? "" : judge_absent(table, made.path, signal, rig);
            if (is_mapped || signal.name == "t_s") {
                throw input_error(line_of(made.path, table.header_line) + "there is no column " + source.column +
                                  " for " + name + "; the columns are " + table.names() + "; " +
                                  (hint.empty() ? "say in the rig file [signals] which one is meant: " + name +
                                                      " = { column = \"...\", scale = ... }"
                                                : hint));
            }
            if (!hint.empty()) {
                hints.push_back(hint);
            }
            continue;
        }
        refuse_twice(rig, table, made.path, source);
        refuse_other_unit(made, table, signal, source, *column);
        refuse_absurd(column->values, table, made.path, source, signal.name == "t_s");
        std::vector<double> &values = made.*signal.member;
        values = column->values;
        for (double &value : values) {
            value = source.scale * value + source.offset;
        }
        if (is_mapped && table.find(name) != nullptr) {
            made.notes.push_back(that_is_left_out(name, source.column));
        }
    }
    const bool is_useful =
        can_replay(made, block::manipulator) || can_replay(made, block::robot) || can_replay(made, block::force);
    if (!is_useful && !hints.empty()) {
        throw input_error(line_of(made.path, table.header_line) + hints.front());
    }
    made.notes.insert(made.notes.end(), hints.begin(), hints.end());
}

void check_outputs(const record &made, const std::string &place)
{
    for (const signal_member &signal : signal_members) {
        if (signal.is_output && is_still(made.*signal.member)) {
            throw input_error(place + that_is_still(made, signal) +
                              "a column that never changes says nothing about the rig; leave it out");
        }
    }
}

void check_operator(record &made, const std::string &place)
{
    for (const signal_member &signal : signal_members) {
        if (signal.is_output || signal.name == "t_s" || !is_still(made.*signal.member)) {
            continue;
        }
        const bool is_velocity = signal.name == "operator_velocity_m_per_s";
        const bool moves = !made.operator_position_m.empty() && !is_still(made.operator_position_m);
        if (is_velocity && moves && made.operator_velocity_m_per_s.front() == 0.0) {
            throw input_error(place + that_is_still(made, signal) +
                              "and operator_position_m moves: leave the column out, or record it");
        }
        if (!is_velocity && made.force_N.empty()) {
            throw input_error(
                place + that_is_still(made, signal) +
                "and without force_N nothing drives the manipulator: was the sensor connected? leave the "
                "column out, or record it");
        }
        if (!is_velocity) {
            made.notes.push_back(that_is_still(made, signal) + "if nobody measured it, leave the column out");
        }
    }
}

} // namespace berth
