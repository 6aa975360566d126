/* What `berth reduce` tells of a reduction, in JSON and in words. */
#ifndef SIM_HAL_CLI_REDUCTION_REPORT_H
#define SIM_HAL_CLI_REDUCTION_REPORT_H

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "../stability/reduction.h"

namespace berth
{

/* Where the robot has further axes: what of the comparison is about which of them. */
std::vector<std::string> what_is_compared(const rig &rig);

/* "1.35, -1.7" */
std::string text_of(const Eigen::VectorXd &values);

/* "along (1, 0), guided, satellite free" */
std::string conditions_text(const arm_config &arm, const reduction_choice &choice);

nlohmann::json as_json(const Eigen::VectorXd &pose_rad, const reduction &found);
nlohmann::json as_json(const object_reduction &found);

void print_reduction(const reduction &found);
void print_object(const rig &rig, const object_reduction &found);

void print_sweep_head();
void print_sweep_row(double angle_rad, const reduction &found);

} // namespace berth

#endif
