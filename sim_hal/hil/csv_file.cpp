#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <sstream>

#ifdef BERTH_WITH_ZLIB
#include <zlib.h>
#else
#include <fstream>
#endif

#include "../../hal/rig/rig_file.h"
#include "profile.h"

namespace berth
{

namespace
{

#ifdef BERTH_WITH_ZLIB
/* zlib reads plain files as they are. */
std::string read_whole(const std::string &path)
{
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
    if (!file) {
        throw input_error(path + ": cannot be read; is it a file?");
    }
    std::string text;
    char block[1 << 16];
    int got = 0;
    while ((got = gzread(file.get(), block, sizeof block)) > 0) {
        text.append(block, static_cast<std::size_t>(got));
    }
    int error = Z_OK; /* Z_BUF_ERROR: the compressed data stop halfway, of which gzread() tells nothing */
    gzerror(file.get(), &error);
    if (got < 0 || error != Z_OK) {
        throw input_error(path + ": cannot be read to its end; is it damaged?");
    }
    return text;
}
#else
std::string read_whole(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    text << file.rdbuf();
    if (!file || text.fail()) {
        throw input_error(path + ": cannot be read; is it a file?");
    }
    if (text.str().compare(0, 2, "\x1f\x8b") == 0) {
        throw input_error(path + ": is compressed, and this program was built without zlib; gunzip it first");
    }
    return text.str();
}
#endif

std::vector<std::string_view> split(std::string_view line)
{
    std::vector<std::string_view> cells;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) {
        line.remove_suffix(1);
    }
    for (std::size_t comma = 0; comma != std::string_view::npos;
         line.remove_prefix(std::min(comma + 1, line.size()))) {
        comma = line.find(',');
        std::string_view cell = line.substr(0, comma);
        while (!cell.empty() && cell.front() == ' ') {
            cell.remove_prefix(1);
        }
        cells.push_back(cell);
        if (comma == std::string_view::npos) {
            break;
        }
    }
    return cells;
}

/* Fit for a terminal: short, and nothing that it would obey. */
std::string printable(std::string_view text)
{
    constexpr std::size_t longest = 60;
    std::string result(text.substr(0, longest));
    std::replace_if(
        result.begin(), result.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return result + (text.size() > longest ? "..." : "");
}

double number(std::string_view cell, const std::string &where)
{
    double value = 0.0;
    if (cell.size() > 1 && cell.front() == '+') {
        cell.remove_prefix(1);
    }
    const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
        throw input_error(where + ": \"" + printable(cell) + "\" is not a finite number");
    }
    return value;
}

std::size_t column_of(const std::vector<std::string_view> &header, const std::string &name, const std::string &path)
{
    const auto found = std::find(header.begin(), header.end(), name);
    if (found == header.end()) {
        std::string names;
        for (const auto cell : header) {
            names += (names.empty() ? "" : ", ") + printable(cell);
        }
        throw input_error(path + ":1: there is no column " + name + "; the columns are " + names);
    }
    return static_cast<std::size_t>(found - header.begin());
}

} // namespace

csv_columns read_csv_columns(const std::string &path, const std::string &column)
{
    csv_columns read;
    const std::string text = read_whole(path);
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    if (line.compare(0, 3, "\xef\xbb\xbf") == 0) {
        line.erase(0, 3); /* the byte order mark that spreadsheets write */
    }
    const std::string header_line = line;
    const auto header = split(header_line);
    const std::size_t time_at = column_of(header, "t_s", path);
    if (column.empty() && header.size() != 2) {
        throw input_error(path + ":1: has " + std::to_string(header.size() - 1) + " columns beside t_s (" +
                          header_line + "); name one with profile.column");
    }
    const std::size_t value_at = column.empty() ? 1 - time_at : column_of(header, column, path);
    for (int number_of_line = 2; std::getline(lines, line); number_of_line++) {
        const std::string where = path + ":" + std::to_string(number_of_line);
        const auto cells = split(line);
        if (cells.size() == 1 && cells[0].empty()) {
            continue;
        }
        if (cells.size() <= std::max(time_at, value_at)) {
            throw input_error(where + ": has " + std::to_string(cells.size()) + " cells, too few");
        }
        const double time_s = number(cells[time_at], where);
        if (!read.times_s.empty() && time_s <= read.times_s.back()) {
            throw input_error(where + ": t_s does not increase");
        }
        read.times_s.push_back(time_s);
        read.values.push_back(number(cells[value_at], where));
        read.lines.push_back(number_of_line);
    }
    if (read.times_s.size() < 2) {
        throw input_error(path + ": needs at least two rows");
    }
    return read;
}

} // namespace berth
