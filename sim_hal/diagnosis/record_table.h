/* A CSV file as columns of numbers, and what is wrong with it. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_TABLE_H
#define SIM_HAL_DIAGNOSIS_RECORD_TABLE_H

#include <string>
#include <vector>

namespace berth
{

struct table_column {
    std::string name;
    std::vector<double> values;
};

struct record_table {
    std::vector<table_column> columns;
    std::string hash; /* of the file's bytes, unpacked */

    /* nullptr: there is none. */
    const table_column *find(const std::string &name) const;
    std::string names() const;
};

/* Plain or .gz. Only the columns in `wanted` are kept, all must hold finite numbers. Throws input_error with file
 * and line. */
record_table read_record_table(const std::string &path, const std::vector<std::string> &wanted);

} // namespace berth

#endif
