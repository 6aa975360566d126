/* How long the force of a part of a record tells what was before it. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_SENSOR_RINGING_H
#define SIM_HAL_DIAGNOSIS_REPLAY_SENSOR_RINGING_H

#include "../../../hal/rig/rig.h"
#include "../record/record.h"

namespace berth
{

/* A replay begins with all at rest. Where a part begins in motion, the object is hit at the robot's velocity v, and
 * swings on the sensor's spring: F(t) = v sqrt(m ks) exp(-zeta sqrt(ks / m) t). */
class sensor_ringing
{
  public:
    sensor_ringing(const rig &rig, const record &record);

    /* Until it is no more than a tenth of the force's noise, in s; 0 where nothing moves. */
    double dies_away_s(const record_segment &part) const;

    /* Of the object on the sensor's spring. */
    double decay_per_s() const { return decay_per_s_; }

  private:
    double fastest_m_per_s(const record_segment &part) const;

    const record &record_;
    double on_the_way_s_; /* what the robot was told before is */
    double decay_per_s_;
    double swing_N_s_per_m_;
    double heard_N_;
};

} // namespace berth

#endif
