/* CSV files as other programs write them. Found out from the file: comma, semicolon or tab between the cells; point
 * or comma before decimals; UTF-8 or UTF-16, a byte order mark; lines before the names; a row of units below them;
 * comments that begin with # or %; quoted cells (RFC 4180); .gz.
 *
 * Our own: fast-cpp-csv-parser fixes columns and delimiter when it is compiled, libcsv tells no lines and would have
 * to be built for each target, rapidcsv and csv-parser are in no Debian 12; all of them leave everything above but
 * the quotes to their user. */
#ifndef SIM_HAL_HIL_CSV_READER_H
#define SIM_HAL_HIL_CSV_READER_H

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "text_lines.h"

namespace berth
{

struct csv_column {
    std::string name;     /* as in the file */
    std::string row_unit; /* of the row below the names; empty: there is none, or it says nothing */
};

/* "force [N]" goes by the name force_N as well. */
bool is_column_called(std::string_view column, std::string_view name);

/* One row after another. Throws input_error with file and line. */
class csv_reader
{
  public:
    /* Reads on to the first row of numbers. The names are in the first line whose cells `has_names` knows; where no
     * line before the first row of numbers is such, in the line above that row. */
    using names_test = std::function<bool(const std::vector<std::string_view> &cells)>;
    csv_reader(const std::string &path, const names_test &has_names);

    const std::vector<csv_column> &columns() const { return columns_; }
    long header_line() const { return header_line_; }
    long unit_line() const { return unit_line_; } /* 0: there is no row of units */
    std::string names() const;

    /* The next row, which has as many cells as there are columns; false: there is none. */
    bool next();
    long line() const { return line_; }
    /* Of this row. A time may be a number or a stamp, see cell_stamp_s(). */
    double number(std::size_t column);
    std::optional<double> stamp_s(std::size_t column) const;

    /* Of the file's bytes as they are stored, once next() was false. */
    std::string hash() const { return lines_.hash(); }

  private:
    bool next_row(std::string_view &row);
    bool split_whole(std::string_view row, char delimiter);
    void find_header(const names_test &has_names);
    void take_header();
    void take_units();
    void check_mark(std::string_view cell);
    [[noreturn]] void refuse(const std::string &what) const;

    struct kept_row {
        std::string text;
        long line;
    };
    std::string path_;
    text_lines lines_;
    std::deque<kept_row> kept_; /* read ahead */
    std::string row_;           /* the one of these that was told last, or one of several lines */
    std::vector<std::string_view> cells_;
    std::vector<std::string> unquoted_;
    std::vector<csv_column> columns_;
    char delimiter_ = ',';
    char mark_ = '\0';              /* before decimals; not known yet */
    bool is_comma_certain_ = false; /* and no mark between thousands */
    long header_line_ = 0;
    long unit_line_ = 0;
    long line_ = 0;
};

} // namespace berth

#endif
