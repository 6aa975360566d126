/* When the rows of a record were taken: their rate, rows that are late or missing, parts that are apart. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_RECORD_ROWS_H
#define SIM_HAL_DIAGNOSIS_RECORD_RECORD_ROWS_H

#include <cstdint>
#include <string>
#include <vector>

#include "record.h"
#include "row_stamps.h"

namespace berth
{

/* Beside the signals, one a row. */
struct row_marks {
    std::vector<double> labels;      /* of the segment; empty: all follow each other */
    std::vector<std::int32_t> lines; /* in the file; empty: it has none */
};

struct row_spacing {
    row_clock clock;
    std::vector<stamped_part> parts; /* by the labels */
};

/* Throws input_error where time does not run on, or where its rows have no constant rate. */
row_spacing spacing_of(const record &made, const row_marks &marks);

/* Throws input_error where labels are no numbers of parts. Any column may be mapped to them by mistake. */
void check_labels(const record &made, const row_marks &marks, const std::string &column);

/* With the record's period: rows count where they were due. A few rows that are missing are put back, more start a
 * new segment. */
void find_segments(record &made, const std::vector<stamped_part> &parts);

} // namespace berth

#endif
