/* The loop of a rig with a whole arm, small motions, in place of its manipulator of one degree of freedom. */
#ifndef SIM_HAL_STABILITY_ARM_LOOP_H
#define SIM_HAL_STABILITY_ARM_LOOP_H

#include "../../hal/rig/rig.h"
#include "../arm/linear_arm.h"

namespace berth
{

/* One period of the loop as a matrix: the robot displays the tool's way along `direction`, and on the other axes
 * that the rig has; the loads act against it there, over the period as `config` takes them; the arm in between moves
 * in the steps of `config`. Throws input_error for rigs without one-period map and with compensation, which has a
 * model of the manipulator. */
Eigen::MatrixXd arm_loop_matrix(const rig &rig, const arm_config &config, const linear_arm &arm,
                                const Eigen::VectorXd &direction);

/* Eigenvalues of the loop with the arm that the rig has, small motions about its start, the tool moving as it likes;
 * those of what drifts freely, the satellite's flight, left out. */
std::vector<std::complex<double>> arm_loop_eigenvalues(const rig &rig);

/* What would be without robot and dead time, exact, sampled: the arm alone, its attitude control as spring and
 * damper, and with the objects of all axes fixed to its tool. What drifts freely left out. */
std::vector<std::complex<double>> arm_eigenvalues(const rig &rig);
std::vector<std::complex<double>> arm_with_object_eigenvalues(const rig &rig);

/* Largest |z|, and ln|z|/T, of those modes that the force has a part in: what drifts freely, the satellite's flight,
 * is left out. */
struct arm_loop_growth {
    double spectral_radius;
    double growth_per_s;
    double frequency_Hz;
};
arm_loop_growth growth_of(const Eigen::MatrixXd &loop, double period_s);

/* Throws input_error where the steps of the rig's arm would grow by themselves, contact or none: where its fastest
 * mode is beyond what the integrator follows at the loop's period. */
void refuse_unstable_steps(const rig &rig);

/* Throws input_error for a rig with an arm: what reckons with a manipulator of one degree of freedom alone. */
void refuse_arm(const rig &rig);

/* The rig with the arm's mode as its manipulator, and without the arm. */
rig with_reduced(const rig &rig, const arm_mode &mode);

} // namespace berth

#endif
