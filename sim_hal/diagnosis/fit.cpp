#include "fit.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <unsupported/Eigen/NonLinearOptimization>

namespace berth
{

namespace
{

/* Share of a key's value that a rig file which says nothing lets it be off. */
constexpr double usual_tolerance = 0.05;

double &member_of(rig &rig, const rig_key &key)
{
    return *static_cast<double *>(key.member(rig));
}

/* A parameter between its bounds as an angle, so that the optimiser knows no bounds (MINUIT). Counted from 1 rad
 * below the middle: the optimiser measures its first step by the size of the angles, which must not be 0. */
constexpr double angle_of_middle = 1.0;

double value_at(const free_parameter &parameter, double angle)
{
    return parameter.low + 0.5 * (parameter.high - parameter.low) * (1.0 + std::sin(angle - angle_of_middle));
}

/* A start at a bound is drawn a little inside: there the slope is not 0. */
double angle_of(const free_parameter &parameter, double value)
{
    constexpr double inside = 0.995;
    const double s = 2.0 * (value - parameter.low) / (parameter.high - parameter.low) - 1.0;
    return angle_of_middle + std::asin(std::min(inside, std::max(-inside, s)));
}

/* What Eigen's optimiser asks for. */
class problem
{
  public:
    problem(block_model &model, const noise_model &noise, const rig &start,
            const std::vector<free_parameter> &parameters)
        : model_(model), noise_(noise), rig_(start), parameters_(parameters)
    {
        evaluate();
        rows_ = white_.size();
    }

    int inputs() const { return static_cast<int>(parameters_.size()); }
    int values() const { return static_cast<int>(rows_ + parameters_.size()); }

    int operator()(const Eigen::VectorXd &angles, Eigen::VectorXd &out)
    {
        set(angles);
        evaluate();
        out.head(static_cast<Eigen::Index>(rows_)) =
            Eigen::Map<const Eigen::VectorXd>(white_.data(), static_cast<Eigen::Index>(rows_));
        for (std::size_t i = 0; i < parameters_.size(); i++) {
            const free_parameter &p = parameters_[i];
            out(static_cast<Eigen::Index>(rows_ + i)) = (member_of(rig_, *p.key) - p.expected) / p.expected_sd;
        }
        at_ = angles;
        last_ = out;
        return 0;
    }

    int df(const Eigen::VectorXd &angles, Eigen::MatrixXd &jacobian)
    {
        Eigen::VectorXd here(values());
        if (at_.size() != angles.size() || at_ != angles) {
            (*this)(angles, here);
        }
        here = last_;
        const Eigen::VectorXd kept = at_;
        Eigen::VectorXd there(values());
        for (Eigen::Index i = 0; i < angles.size(); i++) {
            Eigen::VectorXd moved = angles;
            const double step =
                angles(i) > angle_of_middle ? -angle_step : angle_step; /* away from the nearer bound */
            moved(i) += step;
            (*this)(moved, there);
            jacobian.col(i) = (there - here) / step;
        }
        at_ = kept;
        last_ = here;
        set(angles);
        return 0;
    }

    void set(const Eigen::VectorXd &angles)
    {
        for (std::size_t i = 0; i < parameters_.size(); i++) {
            member_of(rig_, *parameters_[i].key) = value_at(parameters_[i], angles(static_cast<Eigen::Index>(i)));
        }
    }

    const rig &current() const { return rig_; }
    std::size_t rows() const { return rows_; }
    int replays() const { return replays_; }

  private:
    static constexpr double angle_step = 1e-4;

    void evaluate()
    {
        model_.error(rig_, error_);
        whiten(noise_, error_, model_.uses(), row_use::fit, white_);
        replays_++;
    }

    block_model &model_;
    const noise_model &noise_;
    rig rig_;
    const std::vector<free_parameter> &parameters_;
    std::vector<double> error_;
    std::vector<double> white_;
    Eigen::VectorXd at_;
    Eigen::VectorXd last_;
    std::size_t rows_ = 0;
    int replays_ = 0;
};

/* Half widths from the curvature at the end; the white error's own size counts where it is above 1. */
std::vector<double> intervals(problem &problem, const Eigen::VectorXd &angles,
                              const std::vector<free_parameter> &parameters, double cost_per_row)
{
    Eigen::MatrixXd jacobian(problem.values(), problem.inputs());
    problem.df(angles, jacobian);
    for (std::size_t i = 0; i < parameters.size(); i++) {
        const free_parameter &p = parameters[i];
        const double slope =
            0.5 * (p.high - p.low) *
            std::max(1e-6, std::abs(std::cos(angles(static_cast<Eigen::Index>(i)) - angle_of_middle)));
        jacobian.col(static_cast<Eigen::Index>(i)) /= slope;
    }
    const Eigen::VectorXd scale = jacobian.colwise().norm().cwiseMax(1e-300);
    const Eigen::MatrixXd scaled = jacobian * scale.cwiseInverse().asDiagonal();
    Eigen::MatrixXd information = scaled.transpose() * scaled;
    information.diagonal().array() += 1e-12;
    const Eigen::MatrixXd covariance = information.inverse();
    const double excess = std::max(1.0, cost_per_row);
    std::vector<double> widths;
    for (Eigen::Index i = 0; i < covariance.rows(); i++) {
        widths.push_back(1.96 * std::sqrt(excess * covariance(i, i)) / scale(i));
    }
    return widths;
}

} // namespace

fit_result fit(block_model &model, const noise_model &noise, const rig &start,
               const std::vector<free_parameter> &parameters, int replays_max, double tolerance)
{
    problem problem(model, noise, start, parameters);
    Eigen::VectorXd angles(problem.inputs());
    for (std::size_t i = 0; i < parameters.size(); i++) {
        rig copy = start;
        angles(static_cast<Eigen::Index>(i)) = angle_of(parameters[i], member_of(copy, *parameters[i].key));
    }
    fit_result result;
    result.parameters = parameters;
    if (!parameters.empty()) {
        Eigen::LevenbergMarquardt<berth::problem, double> optimiser(problem);
        optimiser.parameters.ftol = tolerance;
        optimiser.parameters.xtol = 1e-6;
        optimiser.parameters.factor = 0.5;
        optimiser.minimizeInit(angles);
        auto status = Eigen::LevenbergMarquardtSpace::Running;
        while (status == Eigen::LevenbergMarquardtSpace::Running && problem.replays() < replays_max) {
            status = optimiser.minimizeOneStep(angles);
        }
        problem.set(angles);
    }
    result.rig = problem.current();
    result.rows = static_cast<std::size_t>(static_cast<double>(problem.rows()) / noise.rows_per_fact);
    result.cost = cost_of(model, noise, result.rig);
    constexpr double final_tolerance = 1e-4; /* what is looser is only a first look */
    if (!parameters.empty() && tolerance <= final_tolerance) {
        result.ci95 = intervals(problem, angles, parameters,
                                result.cost / static_cast<double>(std::max<std::size_t>(1, result.rows)));
    }
    result.replays = problem.replays();
    return result;
}

double cost_of(block_model &model, const noise_model &noise, const rig &rig, row_use use)
{
    std::vector<double> error;
    std::vector<double> white;
    model.error(rig, error);
    whiten(noise, error, model.uses(), use, white);
    return sum_of_squares(white);
}

std::vector<free_parameter> base_parameters(block block, const rig &given)
{
    std::vector<free_parameter> parameters;
    for (const std::string_view path : base_keys(block, given)) {
        rig copy = given;
        const rig_key *const key = find_key(path);
        const double value = member_of(copy, *key);
        const double tolerance = given.tolerance_of(path).value_or(usual_tolerance);
        if (tolerance > 0.0 && value > 0.0 && value < unlimited) {
            parameters.push_back(
                {key, (1.0 - tolerance) * value, (1.0 + tolerance) * value, value, tolerance * value});
        }
    }
    return parameters;
}

std::vector<free_parameter> effect_parameters(const effect &effect, const rig &start)
{
    const double reach = effect.reach;
    std::vector<free_parameter> parameters;
    for (const effect_parameter &parameter : effect.parameters) {
        rig copy = start;
        const rig_key *const key = find_key(parameter.key);
        const double value = member_of(copy, *key);
        const double size = std::abs(value) > 0.0 ? std::abs(value) : 0.1;
        const double low = std::max(parameter.low, parameter.low < 0.0 ? -reach * size : size / reach);
        const double high = std::min(parameter.high, reach * size);
        if (value != 0.0 || parameter.low < 0.0) {
            parameters.push_back({key, low, high});
        }
    }
    return parameters;
}

std::vector<free_parameter> joined(std::vector<free_parameter> first, const std::vector<free_parameter> &more)
{
    for (const free_parameter &added : more) {
        const auto same = std::find_if(first.begin(), first.end(),
                                       [&](const free_parameter &known) { return known.key == added.key; });
        if (same == first.end()) {
            first.push_back(added);
        } else {
            *same = added;
        }
    }
    return first;
}

} // namespace berth
