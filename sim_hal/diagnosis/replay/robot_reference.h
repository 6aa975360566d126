/* Where the robot is asked to be over time: setpoints, dead time and interpolation; and a walk along it. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_ROBOT_REFERENCE_H
#define SIM_HAL_DIAGNOSIS_REPLAY_ROBOT_REFERENCE_H

#include <vector>

#include "replay.h"

namespace berth
{

/* Of a period: a jump of the reference is at the end of a step as short as this, in which the object sees it; at a
 * tick the robot has jumped when it is asked where it is. */
constexpr double jump_lasts = 1e-8;

/* The reference passes position_m at time_s, counted from the start of the segment; straight lines between. */
struct knot {
    double time_s;
    double position_m;
};

/* How long a setpoint is on its way to the robot: feedback and operator command go first on the bus. A robot's own
 * clock looks for setpoints that have come. */
double setpoint_arrival_s(const rig &rig);

/* The setpoint that a robot stands on where a segment begins: with a dead band not the first one. */
double stands_on_m(const rig &rig, const record &record, const record_segment &part);

/* Of one segment; a limit of the velocity that is on the reference is in it. */
std::vector<knot> reference_knots(const rig &rig, const record &record, const record_segment &part,
                                  const sample_events &events);

/* Walks along the reference, forwards. */
class reference
{
  public:
    reference(const std::vector<knot> &knots, bool holds)
        : next_(knots.data()), end_(knots.data() + knots.size()), holds_(holds), before_{0.0, next_->position_m}
    {
    }

    double at(double time_s)
    {
        while (next_ != end_ && next_->time_s <= time_s) {
            pass_knot();
        }
        return on_line(time_s);
    }

    /* The same; `bulge_m`: see robot_way, of the way there from `from_s`, where the walk is. */
    double at(double time_s, double from_s, double from_m, double &bulge_m)
    {
        double area_m_s = 0.0;
        double begin_s = from_s;
        double begin_m = from_m;
        while (next_ != end_ && next_->time_s <= time_s) {
            const knot end = *next_;
            area_m_s += 0.5 * (begin_m + on_line(end.time_s)) * (end.time_s - begin_s);
            begin_s = end.time_s;
            begin_m = end.position_m;
            pass_knot();
        }
        const double to_m = on_line(time_s);
        area_m_s += 0.5 * (begin_m + to_m) * (time_s - begin_s);
        bulge_m = area_m_s / (time_s - from_s) - 0.5 * (from_m + to_m);
        return to_m;
    }

  private:
    void pass_knot()
    {
        before_ = *next_++;
        slope_m_per_s_ = holds_ || next_ == end_
                             ? 0.0
                             : (next_->position_m - before_.position_m) / (next_->time_s - before_.time_s);
    }

    /* Between the knots that the walk is between; before the first one it stands there. */
    double on_line(double time_s) const { return before_.position_m + slope_m_per_s_ * (time_s - before_.time_s); }

    const knot *next_;
    const knot *end_;
    bool holds_;
    knot before_;
    double slope_m_per_s_ = 0.0;
};

} // namespace berth

#endif
