/* What a tick makes of an arm's small motions: its integrator's steps, and the wheel's torque held between them. */
#ifndef SIM_HAL_STABILITY_ARM_PERIOD_H
#define SIM_HAL_STABILITY_ARM_PERIOD_H

#include <Eigen/Core>

#include "../../firmware/arm/arm_config.h"
#include "../arm/linear_arm.h"

namespace berth
{

/* States q, q' in even scales. */
struct arm_period {
    Eigen::MatrixXd transition;
    Eigen::MatrixXd by_load; /* a column for each axis of the robot: of 1 N, or 1 N m, held over the period */
    Eigen::MatrixXd way;     /* a row for each: of the tool along it, m or rad, by the states */
};

/* `ways`: of the tool along the robot's axes, by q. A wheel that is given its torque once in several ticks counts as
 * one that is in each. */
arm_period period_of(const linear_arm &arm, const arm_config &config, const Eigen::MatrixXd &ways, double period_s);

} // namespace berth

#endif
