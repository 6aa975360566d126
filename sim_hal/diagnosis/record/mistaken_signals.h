/* Signals that fit the rig with another sign or in another unit: mm, cm or inches for m, kN for N, a sensor the
 * other way round; or with the commanded and the measured position exchanged. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_MISTAKEN_SIGNALS_H
#define SIM_HAL_DIAGNOSIS_RECORD_MISTAKEN_SIGNALS_H

#include "record.h"

namespace berth
{

/* Throws input_error, which says what to write into the rig file; where the rig file maps the signal already, that
 * is a note of the record. */
void refuse_mistaken_signals(record &data, const rig &given);

} // namespace berth

#endif
