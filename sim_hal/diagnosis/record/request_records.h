/* The records of a request: read, and refused where they are no evidence. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_REQUEST_RECORDS_H
#define SIM_HAL_DIAGNOSIS_RECORD_REQUEST_RECORDS_H

#include <optional>
#include <vector>

#include "../diagnosis.h"

namespace berth
{

struct records_of_request {
    record fit; /* all records, one after another */
    std::optional<record> validation;
    std::optional<record> standstill;
    std::optional<record> repetition;
    std::vector<input_file> inputs;
    berth::rig given;    /* the request's, at the rate of the record where it states none */
    berth::rig replayed; /* the same, with the age of the force as its delay */
};

/* Throws input_error. */
records_of_request read_records(const diagnosis_request &request);

} // namespace berth

#endif
