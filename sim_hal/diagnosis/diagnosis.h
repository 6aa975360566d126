/* The whole diagnosis: every block that the record can drive, in the order of the loop. */
#ifndef SIM_HAL_DIAGNOSIS_DIAGNOSIS_H
#define SIM_HAL_DIAGNOSIS_DIAGNOSIS_H

#include <functional>
#include <string>
#include <vector>

#include "detectable.h"
#include "next_experiment.h"
#include "search/block_diagnosis.h"

namespace berth
{

struct diagnosis_request {
    std::vector<std::string> records;
    std::string validation; /* may be empty, as the two below */
    std::string repetition;
    std::string standstill;
    berth::rig rig;
    search_options options;
    std::function<void(const std::string &)> progress; /* is told what comes next; may be empty */
};

/* A file that was read. */
struct input_file {
    std::string_view role; /* record, validation, standstill or repetition */
    std::string path;
    std::string hash;      /* of its bytes */
    std::uint64_t content; /* hash of its signals */
};

struct diagnosis {
    berth::verdict verdict = verdict::nothing_detectable;
    std::string located; /* the block that is at fault; empty: none, or more than one */
    std::vector<block_diagnosis> blocks;
    std::vector<block> not_described; /* the record shows them, the rig says nothing of them: not judged */
    berth::rig given;                 /* the request's, at the rate of the record where it was given none */
    berth::rig extended;
    std::vector<detectable_size> detectable; /* of nothing_detectable: what this record would have shown */
    std::optional<next_experiment> next;
    record data;
    std::vector<input_file> inputs;
    std::vector<std::string> notes;
};

/* Throws input_error for records that cannot be used. */
diagnosis diagnose(const diagnosis_request &request);

} // namespace berth

#endif
