/* How old the force of a tick is. In a rig file a sample waits for the tick that takes it; in a diagnosis
 * `sensor.delay_ms` is its whole age, of which a fit may have any. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_SAMPLE_AGE_H
#define SIM_HAL_DIAGNOSIS_RECORD_SAMPLE_AGE_H

#include "../../../hal/rig/rig.h"

namespace berth
{

/* The rig with the age, ms, in the place of the delay; as it is, where the age changes from tick to tick. */
rig with_age_as_delay(const rig &given);

/* Back to what run and eigen read: `given` where the age is still the one it has, else samples that are taken so
 * late in the tick that they arrive when they are needed. */
rig with_delay_of_age(const rig &found, const rig &given);

} // namespace berth

#endif
