/* When a robot's free clock slips, a setpoint taken twice or none, and how its drift and phase may move. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_CLOCK_WAYS_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_CLOCK_WAYS_H

#include <vector>

#include "../fit/fit.h"
#include "../record/record.h"

namespace berth
{

/* Times at which the clock slips: when it looks, another setpoint has just come, or not yet. On the clock's own
 * scale, on which the record begins at time_s.front() - time_origin_s. */
std::vector<double> slip_times_s(const rig &rig, const record &data);

/* The ways in which a clock's drift and phase move without moving the mean lateness, which the dead time makes up
 * for: the drift turns about the middle of the slips, which then stay in their ticks; the phase shifts these. */
class clock_ways
{
  public:
    clock_ways(const fit_result &fitted, const record &data);

    void turn(rig &rig, double by_ppm) const { turn_about(rig, by_ppm, pivot_s); }
    void turn_about(rig &rig, double by_ppm, double time_s) const;
    void shift(rig &rig, double by_ms) const;

    bool has_slips = false;
    double pivot_s = 0.0;

  private:
    void make_up(rig &rig, double late_ms) const;

    double middle_s_ = 0.0;
    double least_ms_ = 0.0; /* dead time; where it is not free, both 0 */
    double most_ms_ = 0.0;
};

} // namespace berth

#endif
