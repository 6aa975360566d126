/* What is known of a rig's parameters before a fit: bounds, and expected values by themselves or together. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_PRIOR_H
#define SIM_HAL_DIAGNOSIS_FIT_PRIOR_H

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "../../../hal/rig/keys.h"

namespace berth
{

/* Where another parameter is off what is expected of it, this one is expected to be off by so many times as much. */
struct leaning {
    const rig_key *on;
    double expected; /* of the other */
    double slope;
};

struct free_parameter {
    const rig_key *key;
    double low; /* bounds */
    double high;
    double expected = 0.0; /* prior: expected value and its standard deviation; infinity: none */
    double expected_sd = std::numeric_limits<double>::infinity();
    std::vector<leaning> leans = {}; /* on those that it was fitted with */
    double leaning_sd = 0.0;         /* standard deviation given theirs */
};

/* How far the parameter is off what is expected, in standard deviations. */
double strain_of(const free_parameter &parameter, const rig &rig);

/* Its change with a parameter's value. */
double strain_slope(const free_parameter &parameter, const rig_key *with);

/* A normal distribution of parameters, of which `alone` has the expected values and the standard deviation of each
 * by itself, as a prior of each given the next ones: squared, the strains of all sum up to the distribution's
 * exponent. `correlation`: square, in the order of `alone`; may be shorter than it, the rest is independent. Those
 * that are not `kept` are taken to be as expected. Bounds: four standard deviations. */
std::vector<free_parameter> known_together(const std::vector<free_parameter> &alone,
                                           const Eigen::MatrixXd &correlation, const std::vector<bool> &kept);

} // namespace berth

#endif
