/* An arm at a pose, for small motions about rest: M q'' + D q' + K q = J' f, and its modes along a direction. */
#ifndef SIM_HAL_ARM_LINEAR_ARM_H
#define SIM_HAL_ARM_LINEAR_ARM_H

#include <complex>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "../../firmware/arm/arm_config.h"
#include "../../firmware/config.h"
#include "../../hal/rig/cantilever.h"
#include "../../hal/rig/rig_file.h"

namespace berth
{

/* q: turn and way of a free base in its axes, links, motors. The attitude's wheel counts as spring and damper;
 * thrusters, gravity and limits do not. */
struct linear_arm {
    Eigen::MatrixXd inertia;
    Eigen::MatrixXd damping;
    Eigen::MatrixXd stiffness;
    Eigen::MatrixXd attitude_damping; /* what of them is the attitude control's */
    Eigen::MatrixXd attitude_stiffness;
    Eigen::MatrixXd tool_turn; /* of the tool in the world's axes, rad, by q */
    Eigen::MatrixXd tool_way;  /* m, by q */

    Eigen::Index count() const { return inertia.rows(); }
};

/* What of the attitude control a loop's small motions know nothing of, each with its key: thrusters, which pulse
 * beyond a dead band, and a wheel's torque that is held for longer than a period. */
std::vector<std::string> attitude_left_out(const arm_config &config);

/* The same of an arm by itself, without a loop's ticks: there a wheel's torque that is held for one period is left
 * out, too, and told where that matters. */
std::vector<std::string> attitude_left_out_without_ticks(const arm_config &config, double period_s);

/* `pose_rad`: of the joints. Throws input_error for an arm under gravity. */
linear_arm linearise(const arm_config &config, const Eigen::VectorXd &pose_rad);

/* The same arm in the coordinates that the columns of `basis` combine. */
linear_arm combined(const linear_arm &arm, const Eigen::MatrixXd &basis);

/* The tool can only move along `direction` (as many numbers as the world has dimensions), and in space not turn:
 * what an object that is guided so leaves of the arm. Coordinates are new ones, orthonormal combinations of q. */
linear_arm guided(const linear_arm &arm, const Eigen::VectorXd &direction);

/* Its coordinates: q = basis * them. */
Eigen::MatrixXd guided_basis(const linear_arm &arm, const Eigen::VectorXd &direction);

/* What of an arm is looked at. */
struct reduction_choice {
    Eigen::VectorXd pose_rad;
    Eigen::VectorXd direction;
    bool is_guided = false; /* else, as in a run, the tool moves as it likes */
};

/* Mass, damper and spring that a mode shows at the tool along the direction. */
struct arm_mode {
    double frequency_Hz; /* 0: nothing holds it */
    double damping_ratio;
    double share;          /* of the tool's mobility along the direction, 1 / mass_kg */
    double attitude_share; /* of the energy in its springs, what the attitude control holds */
    double mass_kg;
    double damping_N_s_per_m;
    double stiffness_N_per_m;
};

/* By rising frequency, without those that the tool along the direction has no part in. Of a guided arm `free` is the
 * one before: against its ways it shows whether the guide leaves the tool any. */
std::vector<arm_mode> modes_along(const linear_arm &arm, const Eigen::VectorXd &direction, const linear_arm &free);
std::vector<arm_mode> modes_along(const linear_arm &arm, const Eigen::VectorXd &direction);

class nothing_springy : public input_error
{
    using input_error::input_error;
};

/* The arm reduced to one degree of freedom: of the modes that its own springs hold, more than the attitude control
 * does, the one along which the tool is most mobile. Throws nothing_springy if there is none. */
arm_mode dominant_mode(const std::vector<arm_mode> &modes);

/* Of M q'' + D q' + K q = 0 by themselves, in 1/s; those with positive imaginary part and real ones. */
std::vector<std::complex<double>> eigenvalues_of(const linear_arm &arm);

/* q of the mode with this eigenvalue. */
Eigen::VectorXcd shape_of(const linear_arm &arm, std::complex<double> s);

/* A manipulator of one degree of freedom as an arm: its tool moves along one direction. */
linear_arm arm_of(const manipulator_config &manipulator);

/* An object of these modes fixed to the tool, whose way along it is `way` by q: the first moves as the tool less the
 * others, each of which is a coordinate more. */
linear_arm with_object(const linear_arm &arm, const Eigen::RowVectorXd &way, const std::vector<beam_mode> &modes);

} // namespace berth

#endif
