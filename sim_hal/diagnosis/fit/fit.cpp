#include "fit.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <utility>

#include "../../solver/factors.h"
#include "least_squares.h"

namespace berth
{

namespace
{

double &member_of(rig &rig, const rig_key &key)
{
    return *static_cast<double *>(key.member(rig));
}

double rows_in_use(const std::vector<row_use> &uses)
{
    return static_cast<double>(std::count(uses.begin(), uses.end(), row_use::fit));
}

/* A parameter as a number between 0 at its lower bound and 1 at the upper one; by decades where these are far apart.
 */
class scale
{
  public:
    explicit scale(const free_parameter &parameter)
        : low_(parameter.low), high_(parameter.high), by_decades_(low_ > 0.0 && high_ > 4.0 * low_)
    {
    }
    double value_at(double place) const
    {
        return by_decades_ ? low_ * std::pow(high_ / low_, place) : low_ + (high_ - low_) * place;
    }
    double place_of(double value) const
    {
        return by_decades_ ? std::log(std::max(value, low_) / low_) / std::log(high_ / low_)
                           : (value - low_) / (high_ - low_);
    }
    /* Change of the value with the place. */
    double slope_at(double place) const
    {
        return by_decades_ ? std::log(high_ / low_) * value_at(place) : high_ - low_;
    }

  private:
    double low_;
    double high_;
    bool by_decades_;
};

/* White error and, below it, what the parameters are off from what was expected. */
class problem
{
  public:
    problem(block_model &model, const noise_model &noise, const rig &start,
            const std::vector<free_parameter> &parameters)
        : model_(model), noise_(noise), rig_(start), parameters_(parameters),
          scales_(parameters.begin(), parameters.end())
    {
    }

    Eigen::VectorXd start() const
    {
        Eigen::VectorXd places(count());
        rig copy = rig_;
        for (Eigen::Index i = 0; i < count(); i++) {
            places(i) = scales_[at(i)].place_of(member_of(copy, *parameters_[at(i)].key));
        }
        return places;
    }

    void residual(const Eigen::VectorXd &places, Eigen::VectorXd &out)
    {
        set(places);
        model_.error(rig_, error_);
        weigh(out);
    }

    void residual_beside(const Eigen::VectorXd &places, Eigen::VectorXd &out)
    {
        set(places);
        model_.error_beside(rig_, error_);
        weigh(out);
    }

    void weigh(Eigen::VectorXd &out)
    {
        whiten(noise_, error_, model_.uses(), row_use::fit, white_);
        rows_ = static_cast<Eigen::Index>(white_.size());
        out.resize(rows_ + count());
        out.head(rows_) = Eigen::Map<const Eigen::VectorXd>(white_.data(), rows_);
        for (Eigen::Index i = 0; i < count(); i++) {
            out(rows_ + i) = strain_of(parameters_[at(i)], rig_);
        }
    }

    void set(const Eigen::VectorXd &places)
    {
        for (Eigen::Index i = 0; i < count(); i++) {
            member_of(rig_, *parameters_[at(i)].key) = scales_[at(i)].value_at(places(i));
        }
    }

    /* Slopes by value in those by place. */
    void give_slopes(const known_slopes &known, const Eigen::VectorXd &places, least_squares_problem &task) const
    {
        task.slopes = Eigen::MatrixXd::Zero(known.white.rows() + count(), count());
        task.slope_is_known.assign(parameters_.size(), false);
        for (Eigen::Index i = 0; i < count(); i++) {
            const auto same = std::find(known.keys.begin(), known.keys.end(), parameters_[at(i)].key);
            if (same == known.keys.end()) {
                continue;
            }
            const double by_place = scales_[at(i)].slope_at(places(i));
            task.slopes.col(i).head(known.white.rows()) = by_place * known.white.col(same - known.keys.begin());
            for (Eigen::Index j = 0; j < count(); j++) {
                task.slopes(known.white.rows() + j, i) =
                    by_place * strain_slope(parameters_[at(j)], parameters_[at(i)].key);
            }
            task.slope_is_known[at(i)] = true;
        }
    }

    const rig &current() const { return rig_; }
    Eigen::Index rows() const { return rows_; }
    Eigen::Index count() const { return static_cast<Eigen::Index>(parameters_.size()); }
    double slope_at(Eigen::Index i, double place) const { return scales_[at(i)].slope_at(place); }
    double value_at(Eigen::Index i, double place) const { return scales_[at(i)].value_at(place); }

  private:
    static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

    block_model &model_;
    const noise_model &noise_;
    rig rig_;
    const std::vector<free_parameter> &parameters_;
    std::vector<scale> scales_;
    std::vector<double> error_;
    std::vector<double> white_;
    Eigen::Index rows_ = 0;
};

/* What the slopes and the white error have in common, block by block of about half a second: its spread shows how
 * far the parameters may be off although the error is neither white nor what the model takes it for (the sandwich
 * estimator of Huber 1967 and White 1980, clustered in time). */
Eigen::MatrixXd spread_of_scores(const Eigen::MatrixXd &jacobian, const Eigen::VectorXd &residual, Eigen::Index rows,
                                 Eigen::Index block)
{
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(jacobian.cols(), jacobian.cols());
    double blocks = 0.0;
    for (Eigen::Index begin = 0; begin < rows; begin += block) {
        const Eigen::Index count = std::min(block, rows - begin);
        const Eigen::VectorXd score = jacobian.middleRows(begin, count).transpose() * residual.segment(begin, count);
        spread += score * score.transpose();
        blocks += 1.0;
    }
    const double free = std::max(1.0, blocks - static_cast<double>(jacobian.cols()));
    const Eigen::MatrixXd prior = jacobian.bottomRows(jacobian.rows() - rows);
    return spread * (blocks / free) + prior.transpose() * prior;
}

/* Half widths of the intervals, and what the parameters have in common. */
struct spread {
    std::vector<double> ci95;
    std::vector<double> ci95_if_slow;
    Eigen::MatrixXd correlation;
};

/* Of a parameter that does nothing over the step of a slope, as a threshold may: how far it goes, up or down, until
 * the sum of squares has risen by what ends an interval of 95 %, or to its bound; at most twice too wide. */
double half_width_where_flat(problem &problem, const Eigen::VectorXd &places, Eigen::Index i)
{
    constexpr double rise = 3.84;
    constexpr double first_step = 1e-4;
    Eigen::VectorXd residual;
    problem.residual(places, residual);
    const double most = residual.squaredNorm() + rise;
    double widest = 0.0;
    for (const double bound : {0.0, 1.0}) {
        Eigen::VectorXd moved = places;
        for (int doublings = 0; moved(i) != bound; doublings++) {
            const double step = std::ldexp(first_step, doublings);
            moved(i) = bound == 0.0 ? std::max(0.0, places(i) - step) : std::min(1.0, places(i) + step);
            problem.residual(moved, residual);
            if (residual.squaredNorm() > most) {
                break;
            }
        }
        widest = std::max(widest, std::abs(problem.value_at(i, moved(i)) - problem.value_at(i, places(i))));
    }
    return widest;
}

/* Half widths: from the curvature at the end, the white error's own size counting where it is above 1, or from the
 * spread over the record, whichever is wider. */
spread spread_of(problem &problem, const least_squares_result &found, double cost_per_row, Eigen::Index block)
{
    Eigen::MatrixXd jacobian = found.jacobian;
    for (Eigen::Index i = 0; i < jacobian.cols(); i++) {
        jacobian.col(i) /= problem.slope_at(i, found.x(i));
    }
    const Eigen::VectorXd scale = jacobian.colwise().norm().cwiseMax(1e-300);
    const Eigen::MatrixXd scaled = jacobian * scale.cwiseInverse().asDiagonal();
    Eigen::MatrixXd information = scaled.transpose() * scaled;
    information.diagonal().array() += 1e-12;
    const Eigen::MatrixXd covariance = inverse(information);
    const auto sandwich_of = [&](Eigen::Index rows) {
        return Eigen::MatrixXd(covariance * spread_of_scores(scaled, found.residual, problem.rows(), rows) *
                               covariance);
    };
    const Eigen::MatrixXd sandwich = sandwich_of(block);
    const Eigen::Index long_blocks = std::max<Eigen::Index>(12, 3 * covariance.rows());
    const Eigen::MatrixXd slow_sandwich = sandwich_of(std::max(block, problem.rows() / long_blocks + 1));
    constexpr double of_few_blocks = 2.2; /* Student's factor of 95 % for eleven */
    const double excess = std::max(1.0, cost_per_row);
    spread made;
    made.ci95.reserve(static_cast<std::size_t>(covariance.rows()));
    for (Eigen::Index i = 0; i < covariance.rows(); i++) {
        if (jacobian.col(i).norm() == 0.0) {
            made.ci95.push_back(half_width_where_flat(problem, found.x, i));
            made.ci95_if_slow.push_back(made.ci95.back());
            continue;
        }
        made.ci95.push_back(1.96 * std::sqrt(std::max(excess * covariance(i, i), sandwich(i, i))) / scale(i));
        made.ci95_if_slow.push_back(
            std::max(made.ci95.back(), of_few_blocks * std::sqrt(slow_sandwich(i, i)) / scale(i)));
    }
    const Eigen::VectorXd alone = covariance.diagonal().cwiseSqrt().cwiseInverse();
    made.correlation = alone.asDiagonal() * covariance * alone.asDiagonal();
    return made;
}

/* Of what coarse steps of the input leave open nothing is evidence, however little of it an effect leaves: one that
 * smooths takes the steps out of the command, whatever the robot did. */
double no_less_than_open(const block_model &model, const noise_model &noise, double cost, Eigen::Index rows)
{
    return std::max(cost, static_cast<double>(rows) * std::pow(model.open_by_input_rms() / noise.sigma, 2));
}

} // namespace

fit_result fit(block_model &model, const noise_model &noise, const rig &start,
               const std::vector<free_parameter> &parameters, int replays_max, const known_slopes *first_look)
{
    constexpr double difference = 1e-4; /* of the way between the bounds */
    fit_result result;
    result.parameters = parameters;
    problem problem(model, noise, start, parameters);
    if (parameters.empty()) {
        Eigen::VectorXd residual;
        problem.residual({}, residual);
        result.rig = start;
        result.cost = no_less_than_open(model, noise, residual.squaredNorm(), problem.rows());
        result.replays = 1;
    } else {
        least_squares_problem task;
        task.residual = [&](const Eigen::VectorXd &x, Eigen::VectorXd &out) { problem.residual(x, out); };
        if (model.which() == block::manipulator) {
            task.residual_beside = [&](const Eigen::VectorXd &x, Eigen::VectorXd &out) {
                problem.residual_beside(x, out);
            };
        }
        task.low = Eigen::VectorXd::Zero(problem.count());
        task.high = Eigen::VectorXd::Ones(problem.count());
        task.step = Eigen::VectorXd::Constant(problem.count(), difference);
        task.evaluations_max = replays_max;
        task.change_max = change_max_per_row * std::sqrt(rows_in_use(model.uses()));
        const Eigen::VectorXd places = problem.start();
        if (first_look != nullptr) {
            problem.give_slopes(*first_look, places, task);
            task.is_first_look = true;
            task.tolerance = 2e-4;
        }
        const least_squares_result found = solve_least_squares(task, places);
        problem.set(found.x);
        result.rig = problem.current();
        result.cost =
            no_less_than_open(model, noise, found.residual.head(problem.rows()).squaredNorm(), problem.rows());
        result.replays = found.evaluations;
        if (first_look == nullptr) {
            const double rows = std::max(1.0, static_cast<double>(problem.rows()) / noise.rows_per_fact);
            const auto half_second = static_cast<Eigen::Index>(0.5 / model.data().period_s);
            const Eigen::Index block = std::max<Eigen::Index>(5, std::min(half_second, problem.rows() / 40));
            spread known = spread_of(problem, found, result.cost / rows, block);
            result.ci95 = std::move(known.ci95);
            result.ci95_if_slow = std::move(known.ci95_if_slow);
            result.correlation = std::move(known.correlation);
        }
    }
    result.rows = static_cast<std::size_t>(static_cast<double>(problem.rows()) / noise.rows_per_fact);
    return result;
}

double cost_of(block_model &model, const noise_model &noise, const rig &rig, row_use use)
{
    std::vector<double> error;
    std::vector<double> white;
    model.error(rig, error);
    whiten(noise, error, model.uses(), use, white);
    return no_less_than_open(model, noise, sum_of_squares(white), static_cast<Eigen::Index>(white.size()));
}

std::vector<free_parameter> as_known(const fit_result &fitted, const std::vector<bool> &kept)
{
    std::vector<free_parameter> alone;
    for (std::size_t i = 0; i < fitted.ci95.size(); i++) {
        const rig_key *const key = fitted.parameters[i].key;
        alone.push_back({key, 0.0, 0.0, value_of(fitted.rig, key->path), fitted.ci95[i] / 1.96});
    }
    return known_together(alone, fitted.correlation, kept);
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
