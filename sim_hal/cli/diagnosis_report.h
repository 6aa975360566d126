/* A diagnosis on the terminal, and what its text and its JSON must say alike. */
#ifndef SIM_HAL_CLI_DIAGNOSIS_REPORT_H
#define SIM_HAL_CLI_DIAGNOSIS_REPORT_H

#include "../diagnosis/diagnosis.h"
#include "../diagnosis/noise/error_place.h"

namespace berth
{

constexpr const char *next_experiment_file = "next_experiment.csv";

struct interval {
    double low;
    double high;
};

/* Of 95 %, within what the key may be. */
interval interval_of(const parameter_estimate &parameter);

/* A parameter of a cause that was not fitted stands where it was. */
bool is_fitted(const parameter_estimate &parameter);

/* An error is left that nothing explains. */
bool has_rest(const block_diagnosis &block);

/* The floor was estimated beside what nothing explains: it may have taken some of that for noise. */
bool is_floor_open(const block_diagnosis &block);

/* Of its rms, 95 %; from 0 on where it is open. */
interval interval_of_floor(const block_diagnosis &block);

void print_diagnosis(const diagnosis &found, const std::string &out_folder);

} // namespace berth

#endif
