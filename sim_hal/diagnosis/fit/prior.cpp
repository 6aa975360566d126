#include "prior.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "../../effects/effect.h"
#include "../../solver/factors.h"

namespace berth
{

namespace
{

Eigen::Index at(std::size_t i)
{
    return static_cast<Eigen::Index>(i);
}

/* Inverse of the covariance, each parameter in units of its own standard deviation. */
Eigen::MatrixXd information_of(const Eigen::MatrixXd &correlation, Eigen::Index count)
{
    constexpr double least = 1e-12; /* so that it can be inverted */
    const Eigen::Index known = std::min(count, correlation.rows());
    Eigen::MatrixXd made = Eigen::MatrixXd::Identity(count, count);
    Eigen::MatrixXd together = correlation.topLeftCorner(known, known);
    together.diagonal().array() += least;
    made.topLeftCorner(known, known) = positive_inverse(together);
    return made;
}

double deviation_of(const free_parameter &parameter)
{
    return parameter.leans.empty() ? parameter.expected_sd : parameter.leaning_sd;
}

} // namespace

double strain_of(const free_parameter &parameter, const rig &rig)
{
    double off = value_of(rig, parameter.key->path) - parameter.expected;
    for (const leaning &lean : parameter.leans) {
        off -= lean.slope * (value_of(rig, lean.on->path) - lean.expected);
    }
    return off / deviation_of(parameter);
}

double strain_slope(const free_parameter &parameter, const rig_key *with)
{
    if (parameter.key == with) {
        return 1.0 / deviation_of(parameter);
    }
    const auto lean = std::find_if(parameter.leans.begin(), parameter.leans.end(),
                                   [&](const leaning &one) { return one.on == with; });
    return lean == parameter.leans.end() ? 0.0 : -lean->slope / deviation_of(parameter);
}

std::vector<free_parameter> known_together(const std::vector<free_parameter> &alone,
                                           const Eigen::MatrixXd &correlation, const std::vector<bool> &kept)
{
    std::vector<std::size_t> stays;
    for (std::size_t i = 0; i < alone.size(); i++) {
        if (kept[i]) {
            stays.push_back(i);
        }
    }
    const Eigen::MatrixXd all = information_of(correlation, at(alone.size()));
    Eigen::MatrixXd information(at(stays.size()), at(stays.size()));
    for (std::size_t i = 0; i < stays.size(); i++) {
        for (std::size_t j = 0; j < stays.size(); j++) {
            information(at(i), at(j)) = all(at(stays[i]), at(stays[j]));
        }
    }
    const Eigen::MatrixXd root = upper_root(information);
    const Eigen::MatrixXd covariance = positive_inverse(information);
    std::vector<free_parameter> made;
    for (std::size_t i = 0; i < stays.size(); i++) {
        free_parameter one = alone[stays[i]];
        const double unit = one.expected_sd;
        one.expected_sd = unit * std::sqrt(covariance(at(i), at(i)));
        one.low = one.expected - 4.0 * one.expected_sd;
        one.high = one.expected + 4.0 * one.expected_sd;
        one.leaning_sd = unit / root(at(i), at(i));
        for (std::size_t j = i + 1; j < stays.size(); j++) {
            const free_parameter &other = alone[stays[j]];
            const double slope = -root(at(i), at(j)) / root(at(i), at(i)) * unit / other.expected_sd;
            one.leans.push_back({other.key, other.expected, slope});
        }
        made.push_back(std::move(one));
    }
    return made;
}

} // namespace berth
