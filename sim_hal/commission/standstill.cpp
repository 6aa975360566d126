#include "standstill.h"

#include <cmath>
#include <Eigen/Core>

#include "../../hal/rig/tool_load.h"
#include "../solver/decompositions.h"

namespace berth
{

namespace
{

/* Gravity that turns by less than this share of itself between poses tells no mass: 0.6 degrees. */
constexpr double turned_share = 0.01;

/* A drift counts from this many standard errors on. */
constexpr double sure_errors = 4.0;

Eigen::Index force_rows(sensor_axes axes)
{
    return axes == sensor_axes::one ? 1 : 3;
}

/* Unknown: the zero of each axis, and one column of `effect` for each further unknown. */
struct linear_fit {
    Eigen::VectorXd value;
    bool is_told; /* the further unknowns are */
};

linear_fit fit_zero_and(const std::vector<Eigen::MatrixXd> &effects, const std::vector<Eigen::VectorXd> &loads,
                        double smallest)
{
    const Eigen::Index axes = effects.front().rows();
    const Eigen::Index further = effects.front().cols();
    const auto count = static_cast<Eigen::Index>(effects.size());
    Eigen::MatrixXd mean_effect = Eigen::MatrixXd::Zero(axes, further);
    Eigen::VectorXd mean_load = Eigen::VectorXd::Zero(axes);
    for (std::size_t i = 0; i < effects.size(); i++) {
        mean_effect += effects[i] / static_cast<double>(count);
        mean_load += loads[i] / static_cast<double>(count);
    }
    Eigen::MatrixXd turned(axes * count, further);
    Eigen::VectorXd changed(axes * count);
    for (Eigen::Index i = 0; i < count; i++) {
        turned.middleRows(axes * i, axes) = effects[static_cast<std::size_t>(i)] - mean_effect;
        changed.segment(axes * i, axes) = loads[static_cast<std::size_t>(i)] - mean_load;
    }
    const double least_squared =
        symmetric_eigenpairs(turned.transpose() * turned).values(0); /* of the singular values */
    linear_fit fit;
    fit.is_told = turned.rows() >= further && least_squared > smallest * smallest;
    fit.value = Eigen::VectorXd::Zero(axes + further);
    if (fit.is_told) {
        fit.value.tail(further) = least_norm_solution(turned, changed);
        fit.value.head(axes) = mean_load - mean_effect * fit.value.tail(further);
    }
    return fit;
}

Eigen::Vector3d vector_of(const std::array<double, 3> &values)
{
    return {values[0], values[1], values[2]};
}

Eigen::Matrix3d cross(const Eigen::Vector3d &of)
{
    Eigen::Matrix3d matrix;
    matrix << 0.0, -of(2), of(1), of(2), 0.0, -of(0), -of(1), of(0), 0.0;
    return matrix;
}

void estimate_mass(tool_estimate &made, const std::vector<pose_reading> &poses, sensor_axes axes)
{
    const Eigen::Index rows = force_rows(axes);
    std::vector<Eigen::MatrixXd> effects;
    std::vector<Eigen::VectorXd> loads;
    for (const pose_reading &pose : poses) {
        effects.emplace_back(-vector_of(pose.gravity_m_per_s2).head(rows));
        loads.emplace_back(Eigen::Map<const Eigen::VectorXd>(pose.load.data(), rows));
    }
    const linear_fit fit = fit_zero_and(effects, loads, turned_share * vector_of(poses[0].gravity_m_per_s2).norm());
    made.mass_is_measured = fit.is_told;
    if (fit.is_told) {
        made.tool.mass_kg = fit.value(rows);
    }
}

/* torque = zero + mass * gravity x centre; m c is the unknown. */
void estimate_centre(tool_estimate &made, const std::vector<pose_reading> &poses)
{
    std::vector<Eigen::MatrixXd> effects;
    std::vector<Eigen::VectorXd> loads;
    for (const pose_reading &pose : poses) {
        effects.emplace_back(cross(vector_of(pose.gravity_m_per_s2)));
        loads.emplace_back(Eigen::Map<const Eigen::VectorXd>(pose.load.data() + 3, 3));
    }
    const linear_fit fit = fit_zero_and(effects, loads, turned_share * vector_of(poses[0].gravity_m_per_s2).norm());
    made.centre_is_measured = fit.is_told && made.tool.mass_kg > 0.0;
    if (made.centre_is_measured) {
        for (std::size_t i = 0; i < 3; i++) {
            made.tool.centre_m[i] = fit.value(static_cast<Eigen::Index>(i) + 3) / made.tool.mass_kg;
        }
    }
}

} // namespace

double standstill::mean_error() const
{
    return samples > 0 ? noise / std::sqrt(static_cast<double>(samples)) : 0.0;
}

bool standstill::drifts(double smallest) const
{
    return std::abs(drift_per_s) > sure_errors * drift_error && std::abs(drift_per_s) * duration_s > smallest;
}

standstill standstill_of(const std::vector<double> &samples, double step_s)
{
    standstill found;
    found.samples = samples.size();
    if (samples.size() < 3) {
        found.mean = samples.empty() ? 0.0 : samples.front();
        return found;
    }
    const auto count = static_cast<double>(samples.size());
    for (const double sample : samples) {
        found.mean += sample / count;
    }
    double moment = 0.0;
    double spread = 0.0;
    for (std::size_t i = 0; i < samples.size(); i++) {
        const double time_s = step_s * (static_cast<double>(i) - 0.5 * (count - 1.0));
        moment += time_s * (samples[i] - found.mean);
        spread += time_s * time_s;
    }
    found.drift_per_s = moment / spread;
    double square_sum = 0.0;
    for (std::size_t i = 0; i < samples.size(); i++) {
        const double time_s = step_s * (static_cast<double>(i) - 0.5 * (count - 1.0));
        const double rest = samples[i] - found.mean - found.drift_per_s * time_s;
        square_sum += rest * rest;
    }
    found.noise = std::sqrt(square_sum / (count - 2.0));
    found.drift_error = found.noise / std::sqrt(spread);
    found.duration_s = step_s * (count - 1.0);
    return found;
}

tool_estimate estimate_tool(const std::vector<pose_reading> &poses, sensor_axes axes, const tool_rig &assumed)
{
    tool_estimate made;
    made.tool = assumed;
    if (poses.empty()) {
        return made;
    }
    if (poses.size() > 1) {
        estimate_mass(made, poses, axes);
    }
    if (poses.size() > 1 && axes == sensor_axes::all) {
        estimate_centre(made, poses);
    }
    for (const pose_reading &pose : poses) {
        tool_rig posed = made.tool;
        posed.gravity_m_per_s2 = pose.gravity_m_per_s2;
        const sensor_load weight = tool_load(posed);
        for (std::size_t i = 0; i < 6; i++) {
            made.zero[i] += (pose.load[i] - weight[i]) / static_cast<double>(poses.size());
        }
    }
    return made;
}

} // namespace berth
