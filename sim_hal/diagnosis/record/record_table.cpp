#include "record_table.h"

#include <algorithm>

#include "../../../hal/rig/rig_file.h"
#include "../../hil/csv_cells.h"
#include "../../hil/csv_reader.h"

namespace berth
{

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
    const auto found = std::find_if(columns.begin(), columns.end(),
                                    [&](const table_column &known) { return is_column_called(known.name, name); });
    return found == columns.end() ? nullptr : &*found;
}

std::string record_table::names() const
{
    std::string all;
    for (const table_column &column : columns) {
        all += (all.empty() ? "" : ", ") + printable_cell(column.name);
    }
    return all;
}

record_table read_record_table(const std::string &path, const std::string &time_column,
                               const std::vector<std::string> &wanted)
{
    csv_reader file(path, [&](const std::vector<std::string_view> &cells) {
        return std::any_of(cells.begin(), cells.end(),
                           [&](std::string_view cell) { return is_column_called(cell, time_column); });
    });
    record_table table;
    table.header_line = file.header_line();
    table.unit_line = file.unit_line();
    std::vector<std::size_t> kept;
    std::optional<std::size_t> time;
    for (const csv_column &column : file.columns()) {
        const auto name = std::find_if(wanted.begin(), wanted.end(),
                                       [&](const std::string &one) { return is_column_called(column.name, one); });
        if (name != wanted.end()) {
            if (table.find(*name) != nullptr) {
                throw input_error(path + ":" + std::to_string(table.header_line) + ": two columns are called " +
                                  printable_cell(*name) + "; rename the one that is not meant");
            }
            kept.push_back(table.columns.size());
            time = *name == time_column ? kept.back() : time;
        }
        table.columns.push_back({column.name, column.row_unit, {}});
    }
    while (file.next()) {
        check_row_count(path, table.lines.size() + 1);
        table.lines.push_back(static_cast<std::int32_t>(file.line()));
        for (const std::size_t column : kept) {
            const auto stamp_s = column == time ? file.stamp_s(column) : std::nullopt;
            table.columns[column].values.push_back(stamp_s ? *stamp_s : file.number(column));
        }
    }
    table.hash = file.hash();
    return table;
}

} // namespace berth
