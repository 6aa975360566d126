/* What stages do to a sine: describing functions, the first harmonic of what comes out over that of what goes in
 * (Gelb and Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, 1968, eq. 2.2-5), taken
 * from the very stages that the simulated rig runs with. */
#ifndef SIM_HAL_STABILITY_DESCRIBING_FUNCTION_H
#define SIM_HAL_STABILITY_DESCRIBING_FUNCTION_H

#include <complex>

#include "../../hal/rig/rig.h"
#include "../effects/stages.h"

namespace berth
{

/* mean + amplitude sin(w t) */
struct sine {
    double amplitude;
    double mean;
    double w_rad_per_s;
};

/* A force as spring and damper that make the same first harmonic, and what it pulls on average. */
struct spring_and_damper {
    double stiffness_N_per_m = 0.0;
    double damping_N_s_per_m = 0.0;
    double mean_N = 0.0;
};

/* Complex gain of a signal through a stage. */
std::complex<double> gain_of(motion_stage &stage, const sine &in);

/* Of setpoints through what the robot does to them, once a tick: gain, dead band, limits. */
std::complex<double> setpoint_gain(const rig &rig, const sine &in);

/* Of the force through the sensor's electronics: gain, steps, saturation; without noise, bias and disturbances. */
double sample_gain(const rig &rig, double amplitude_N);

/* Of a further force on a body of this mass, whose spring is at rest where its position is `rest_m`. */
spring_and_damper force_of(force_stage &stage, const sine &position_m, double rest_m, double mass_kg);

/* Dynamic stiffness F/r in N/m of an object that lets go of the robot or of the material, the robot moving with a
 * sine, and the mean of F. */
struct robot_load {
    std::complex<double> stiffness_N_per_m;
    double mean_N;
};
robot_load load_of(const rig &rig, const sine &robot_m);

} // namespace berth

#endif
