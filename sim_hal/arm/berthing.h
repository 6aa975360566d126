/* A berthing manoeuvre for an arm, as a thing to measure accuracy with: the tool approaches a soft surface, touches
 * and presses it, grips the object behind it, swings it, and is driven back; attitude control at work. */
#ifndef SIM_HAL_ARM_BERTHING_H
#define SIM_HAL_ARM_BERTHING_H

#include <string>
#include <vector>

#include "../../firmware/arm/attitude_control.h"
#include "../../firmware/arm/integrators.h"

namespace berth
{

/* Object: a mass on a spring that moves along the direction; held firmly across it. */
struct berthing_plan {
    Eigen::Vector3d direction = Eigen::Vector3d::UnitX(); /* of approach, in the world */
    double duration_s = 60.0;
    double command_period_s = 0.02; /* of joint commands and attitude control: every step divides it */
    double gap_m = 0.3;             /* from tool to surface at the start */
    double press_m = 0.05;          /* commanded beyond the surface */
    double swing_m = 0.05;
    double grip_s = 30.0; /* the grip closes */
    double mass_kg = 100.0;
    double stiffness_N_per_m = 2368.705056261446; /* the object's of the reference case */
    double damping_N_s_per_m = 19.46773764467334;
    double contact_N_per_m = 5000.0; /* surface; F = k depth (1 + c rate), Hunt and Crossley 1975 */
    double contact_s_per_m = 2.0;
    double object_step_s = 1e-4; /* at most, of the object's own Runge-Kutta steps beside an arm in fixed steps */
    double grip_N_per_m = 2e4;
    double grip_N_s_per_m = 200.0;
};

/* What is compared at the end of every command period. */
struct berthing_sample {
    Eigen::Vector3d tool_m; /* in the world */
    Eigen::Vector3d force_N;
    double energy_J; /* of arm and springs of its joints */
};

/* `force`: what the arm's step gets.
 *     mean       over the step, from the truth: nothing but the integrator errs
 *     held       the one at the step's begin: the object moves with the tool meanwhile
 *     led        the same, led by half a step on the line through the last two: what holding costs is taken back
 * The loop does one of the last two, see enum arm_force. */
enum class berthing_force { mean, held, led };

struct berthing_truth {
    std::vector<berthing_sample> samples;
    std::vector<Eigen::Vector3d> impulses_N_s; /* of the force until each multiple of grid_s */
    double grid_s = 1e-4;
    int events = 0; /* touches and releases at which the solver was stopped and started again */
};

/* What the manoeuvre asks of a joint: its motor is led past the limits of guidance, which the plan knows nothing of.
 */
struct joint_demand {
    double rate_rad_per_s; /* the largest */
    double least_rad;
    double most_rad;
};
std::vector<joint_demand> berthing_demands(const arm_config &arm, const berthing_plan &plan);

/* Throws input_error where the tool cannot be led along the direction. */
berthing_truth true_berthing(const arm_config &arm, const berthing_plan &plan, double relative_tolerance);

/* Fixed steps: as the firmware makes them, each in substeps over which the force is the same. */
struct fixed_step {
    double step_s; /* a multiple of the truth's grid */
    std::int64_t substeps;
};

/* The same in fixed steps. */
std::vector<berthing_sample> stepped_berthing(const arm_config &arm, const berthing_plan &plan,
                                              arm_integrator integrator, const fixed_step &step,
                                              berthing_force force, const berthing_truth &truth);

/* Largest momentum about the world's origin that arm, satellite and wheels come to in the manoeuvre's motion without
 * any contact, from rest: it should stay 0. `moved`: the largest that the joints by themselves make, to compare
 * with. */
struct momentum_drift {
    double angular_N_m_s = 0.0;
    double linear_N_s = 0.0;
    double moved_N_s = 0.0;
};
momentum_drift stepped_momentum(const arm_config &arm, const berthing_plan &plan, arm_integrator integrator,
                                const fixed_step &step);

} // namespace berth

#endif
