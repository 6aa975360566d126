/* One line of a CSV file: its cells, and what stands in a cell. */
#ifndef SIM_HAL_HIL_CSV_CELLS_H
#define SIM_HAL_HIL_CSV_CELLS_H

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace berth
{

/* The cells of one row as RFC 4180 has them: within double quotes the delimiter and line ends are text, and "" is
 * one quote. Blanks about a cell are left out. False: a quote is open at the end, and the row goes on in the next
 * line. The cells are valid as long as `row` and `unquoted`, which holds those with quotes within. */
bool split_cells(std::string_view row, char delimiter, std::vector<std::string_view> &cells,
                 std::vector<std::string> &unquoted);

/* A finite number, with `mark` (point or comma) before its decimals; e, E, d or D before its exponent. */
std::optional<double> cell_number(std::string_view cell, char mark);

/* Seconds since 1970 (UTC) of an ISO 8601 stamp such as 2026-03-04T10:11:12.0025Z: T or a blank between, a zone Z or
 * +01:00 or none; seconds since midnight of a clock time 10:11:12.5. */
std::optional<double> cell_stamp_s(std::string_view cell);

/* What is wrong with a cell that is no number, and what to do. */
std::string wrong_cell(std::string_view cell);

/* Fit for a terminal: short, and nothing that it would obey. */
std::string printable_cell(std::string_view text);

} // namespace berth

#endif
