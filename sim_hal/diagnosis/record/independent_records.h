/* Data that prove nothing about each other: a record that copies itself, the same measurement given twice. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_INDEPENDENT_RECORDS_H
#define SIM_HAL_DIAGNOSIS_RECORD_INDEPENDENT_RECORDS_H

#include "../diagnosis.h"

namespace berth
{

/* A record that is its own copy, forwards or backwards, exactly or with noise upon it. A command that is repeated or
 * symmetrical is none, as long as the answer to it was measured twice. Throws input_error. */
void refuse_copies(const record &record);

/* The same data under two names. Throws input_error. */
void refuse_same(const std::vector<input_file> &inputs);

/* A record with the noise of another one: made from it, or from a part of it. Throws input_error. */
void refuse_derived(const record &other, const record &original);

} // namespace berth

#endif
