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

nlohmann::json as_json(const Eigen::VectorXd &pose_rad, const reduction &found);
nlohmann::json as_json(const object_reduction &found);

void print_reduction(const reduction &found);
void print_object(const rig &rig, const object_reduction &found);

/* A sweep: its head, and a line of each pose. */
void print_sweep_head(const std::string &arm, const rig &rig, int joint);
void print_sweep_row(double angle_rad, const reduction &found);

} // namespace berth

#endif
