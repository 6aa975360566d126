#include "record_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <memory>

#ifdef BERTH_WITH_ZLIB
#include <zlib.h>
#endif

#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

/* Rows are bounded; this is for what is none: columns that nobody asked for, empty lines. */
constexpr std::size_t bytes_max = 2000000000;

/* Hands over the file's lines one by one, so that only numbers are kept of it. */
class line_reader
{
  public:
    explicit line_reader(const std::string &path) : path_(path)
    {
#ifdef BERTH_WITH_ZLIB
        file_.reset(gzopen(path.c_str(), "rb"));
#else
        file_.reset(std::fopen(path.c_str(), "rb"));
#endif
        if (!file_) {
            throw input_error(path + ": cannot be read; is it a file?");
        }
    }

    bool next(std::string_view &line)
    {
        for (;;) {
            const std::size_t end = buffer_.find('\n', at_);
            if (end != std::string::npos) {
                line = std::string_view(buffer_).substr(at_, end - at_);
                at_ = end + 1;
                return true;
            }
            buffer_.erase(0, at_);
            at_ = 0;
            if (!fill()) {
                line = buffer_;
                at_ = buffer_.size();
                return !buffer_.empty();
            }
        }
    }

    std::uint64_t hash() const
    {
        return hash_;
    }

  private:
    bool fill()
    {
        char block[1 << 16];
#ifdef BERTH_WITH_ZLIB
        const int got = gzread(file_.get(), block, sizeof block);
#else
        const int got = static_cast<int>(std::fread(block, 1, sizeof block, file_.get()));
#endif
        if (got < 0 || (got == 0 && is_cut_off())) {
            throw input_error(path_ + ": cannot be read to its end; is it damaged, or was it cut off?");
        }
        read_ += static_cast<std::size_t>(got);
        if (read_ > bytes_max) {
            throw input_error(path_ + ": is larger than 2 GB of text; give a part of it, a minute is plenty");
        }
        if (buffer_.size() > (1u << 20)) {
            throw input_error(path_ + ": has a line of more than a megabyte; is it a CSV file?");
        }
        for (int i = 0; i < got; i++) {
            hash_ = (hash_ ^ static_cast<unsigned char>(block[i])) * 0x100000001b3u;
        }
        buffer_.append(block, static_cast<std::size_t>(got));
        return got > 0;
    }

    /* At the end of what can be read: more was to come. */
    bool is_cut_off() const
    {
#ifdef BERTH_WITH_ZLIB
        int error = Z_OK;
        gzerror(file_.get(), &error);
        return error == Z_BUF_ERROR;
#else
        return std::ferror(file_.get()) != 0;
#endif
    }

    struct closer {
#ifdef BERTH_WITH_ZLIB
        void operator()(gzFile_s *file) const
        {
            gzclose(file);
        }
#else
        void operator()(std::FILE *file) const
        {
            std::fclose(file);
        }
#endif
    };
#ifdef BERTH_WITH_ZLIB
    std::unique_ptr<gzFile_s, closer> file_;
#else
    std::unique_ptr<std::FILE, closer> file_;
#endif
    std::string path_;
    std::string buffer_;
    std::size_t at_ = 0;
    std::size_t read_ = 0;
    std::uint64_t hash_ = 0xcbf29ce484222325u;
};

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

record_table read_record_table(const std::string &path, const std::vector<std::string> &wanted)
{
    line_reader lines(path);
    record_table table;
    std::string_view line;
    if (!lines.next(line) || line.empty()) {
        throw input_error(path + ": is empty");
    }
    if (line.substr(0, 3) == "\xef\xbb\xbf") {
        line.remove_prefix(3); /* the byte order mark that spreadsheets write */
    }
    for (bool is_last = false; !is_last;) {
        table.columns.push_back({std::string(take_cell(line, is_last)), {}});
    }
    std::vector<bool> is_wanted;
    for (const table_column &column : table.columns) {
        is_wanted.push_back(std::find(wanted.begin(), wanted.end(), column.name) != wanted.end());
    }
    std::size_t rows = 0;
    for (long row = 2; lines.next(line); row++) {
        if (trimmed(line).empty()) {
            continue;
        }
        check_row_count(path, ++rows);
        bool is_last = false;
        for (std::size_t i = 0; i < table.columns.size(); i++) {
            if (is_last) {
                throw input_error(path + ":" + std::to_string(row) + ": has " + std::to_string(i) +
                                  " cells and not " + std::to_string(table.columns.size()));
            }
            const std::string_view cell = take_cell(line, is_last);
            if (is_wanted[i]) {
                table.columns[i].values.push_back(number(cell, path, row, table.columns[i].name));
            }
        }
    }
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(lines.hash()));
    table.hash = hash;
    return table;
}

} // namespace berth
