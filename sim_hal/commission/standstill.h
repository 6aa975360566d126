/* What a force sensor shows at standstill: zero, noise, drift, and the tool that hangs on it. Pure functions. */
#ifndef SIM_HAL_COMMISSION_STANDSTILL_H
#define SIM_HAL_COMMISSION_STANDSTILL_H

#include <array>
#include <vector>

#include "../../hal/rig/rig.h"

namespace berth
{

/* (force, torque) in the sensor's axes; N, N m. */
using sensor_load = std::array<double, 6>;

/* A straight line through the samples of one axis, by least squares; what is left of it is noise. */
struct standstill {
    double mean = 0.0;
    double noise = 0.0;       /* standard deviation about the line */
    double drift_per_s = 0.0; /* its slope */
    double drift_error = 0.0; /* standard error of the slope, of white noise */
    double duration_s = 0.0;
    std::size_t samples = 0;

    double mean_error() const; /* standard error of the mean, of white noise */
    /* The drift over these samples is larger than noise makes it, and than `smallest`. */
    bool drifts(double smallest) const;
};

/* `samples`: evenly spaced by `step_s`. */
standstill standstill_of(const std::vector<double> &samples, double step_s);

/* One pose: where gravity points in the sensor's axes, and what the sensor shows in the mean. */
struct pose_reading {
    std::array<double, 3> gravity_m_per_s2;
    sensor_load load;
};

/* What a sensor measures: its first axis alone, or forces along all three, with or without torques. */
enum class sensor_axes { one, forces, all };

struct tool_estimate {
    tool_rig tool; /* where the poses do not tell it, as assumed */
    sensor_load zero{};
    bool mass_is_measured = false;
    bool centre_is_measured = false;
};

/* Zero, mass and centre of mass by least squares: load = zero + the tool's weight in each pose. Poses in which
 * gravity points the same way tell the zero alone; the tool is then taken from `assumed`. */
tool_estimate estimate_tool(const std::vector<pose_reading> &poses, sensor_axes axes, const tool_rig &assumed);

} // namespace berth

#endif
