/* A column that a logger wrote some rows below the one where its values belong. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_LATE_ROWS_H
#define SIM_HAL_DIAGNOSIS_RECORD_LATE_ROWS_H

#include "record.h"

namespace berth
{

/* The record with the values of `column` moved up by `late_rows`; less than 0: down. At the end of each part, where
 * none were logged any more, rows are left out. At the begin of it the first value stands for those before. */
record with_column_in_place(record data, std::vector<double> record::*column, int late_rows);

} // namespace berth

#endif
