/* A CSV file as columns of numbers, and what is wrong with it. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_RECORD_TABLE_H
#define SIM_HAL_DIAGNOSIS_RECORD_RECORD_TABLE_H

#include <cstdint>
#include <string>
#include <vector>

namespace berth
{

/* Of a record, however it is stored. Memory and time grow with the rows: a million, three quarters of an hour at
 * 400 Hz, took 0.7 GB and nine minutes of a core, and says hardly more than the minute that a rig needs to show what
 * it does. */
constexpr std::size_t record_rows_max = 1000000;

/* Throws input_error where a record has more rows. */
void check_row_count(const std::string &path, std::size_t rows);

struct table_column {
    std::string name;
    std::string row_unit; /* of the row of units below the names, if there is one that says something */
    std::vector<double> values;
};

struct record_table {
    std::vector<table_column> columns;
    std::vector<std::int32_t> lines; /* of each row in the file, as an editor counts them */
    long header_line = 1;
    long unit_line = 0; /* 0: there is no row of units */
    std::string hash;   /* of the file's bytes as they are stored */

    /* nullptr: there is none. */
    const table_column *find(const std::string &name) const;
    std::string names() const;
};

/* As csv_reader.h has it; a file or a pipe, read once and no further than to the first mistake or a row too many.
 * The names are in the line with `time_column`. Only the columns in `wanted` are kept, all must hold finite numbers,
 * that of time also dates. Throws input_error with file and line. */
record_table read_record_table(const std::string &path, const std::string &time_column,
                               const std::vector<std::string> &wanted);

} // namespace berth

#endif
