/* How long the force of a part of a record tells what was before it. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_SENSOR_RINGING_H
#define SIM_HAL_DIAGNOSIS_REPLAY_SENSOR_RINGING_H

#include <algorithm>

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

    /* Commands that are off by so much, rms, are heard in the force, */
    bool hears(double off_m) const { return stiffness_N_per_m_ * off_m > heard_N_; }

    /* and until when, in s. */
    double forgets_s(double off_m) const;

    double to_a_twentieth_s() const { return 3.0 / std::max(decay_per_s_, 1.0); }

  private:
    double fastest_m_per_s(const record_segment &part) const;

    const record &record_;
    double on_the_way_s_; /* what the robot was told before is */
    double decay_per_s_;  /* of the object on the sensor's spring */
    double stiffness_N_per_m_;
    double swing_N_s_per_m_;
    double heard_N_;
};

} // namespace berth

#endif
