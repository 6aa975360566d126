#include "linear_ticks.h"

#include <Eigen/Core>

namespace berth
{

namespace
{

constexpr auto rows = static_cast<Eigen::Index>(object_steps::rows);

/* Of (state, positions, bulges of the steps). A gripped object is at rest at 0: no constant. */
constexpr Eigen::Index positions = rows;

using columns_of_four = Eigen::Matrix<double, rows, Eigen::Dynamic>;

Eigen::Map<const Eigen::Matrix<double, rows, 1>> as_vector(const std::array<double, object_steps::rows> &column)
{
    return Eigen::Map<const Eigen::Matrix<double, rows, 1>>(column.data());
}

/* Step number `number` of `count` after those in `so_far`. */
columns_of_four with_step(const columns_of_four &so_far, const object_steps::step_map &map, double step_s,
                          Eigen::Index number, Eigen::Index count)
{
    Eigen::Matrix<double, rows, rows> transition;
    for (std::size_t i = 0; i < object_steps::rows; i++) {
        transition.col(static_cast<Eigen::Index>(i)) = as_vector(map.column[i]);
    }
    const Eigen::Matrix<double, rows, 1> by_rise = as_vector(map.column[object_steps::rows + 1]) / step_s;
    columns_of_four made = transition * so_far;
    const auto by_position = as_vector(map.column[object_steps::rows]);
    made.col(positions + number) += by_position - by_rise;
    made.col(positions + number + 1) += by_rise;
    made.col(positions + count + 1 + number) += by_position;
    return made;
}

linear_ticks::state as_state(const columns_of_four &all, Eigen::Index column)
{
    linear_ticks::state made{};
    Eigen::Map<Eigen::Matrix<double, rows, 1>>(made.data()) = all.col(column);
    return made;
}

} // namespace

linear_ticks::linear_ticks(const tick_steps &tick, const std::vector<object_steps::step_maps> &maps)
    : samples_within_(tick.sample_after > 0)
{
    const auto count = static_cast<Eigen::Index>(tick.count());
    columns_of_four all = columns_of_four::Zero(rows, positions + count + 1 + count);
    all.leftCols<rows>().setIdentity();
    for (std::size_t step = 0; step < tick.count(); step++) {
        if (samples_within_ && step == tick.sample_after) {
            const Eigen::VectorXd force = all.row(filter_output);
            sample_.assign(force.data(), force.data() + force.size());
        }
        const auto &map = maps[tick.kind[step]][static_cast<std::size_t>(object_steps::grip::holds)];
        all = with_step(all, map, tick.duration_s[step], static_cast<Eigen::Index>(step), count);
    }
    for (Eigen::Index i = 0; i < rows; i++) {
        of_state_[static_cast<std::size_t>(i)] = as_state(all, i);
    }
    for (Eigen::Index i = 0; i <= count; i++) {
        of_position_.push_back(as_state(all, positions + i));
    }
    for (Eigen::Index i = 0; i < count; i++) {
        of_bulge_.push_back(as_state(all, positions + count + 1 + i));
    }
}

double linear_ticks::advance(state &of, const double *position_m, const double *bulge_m) const
{
    const state s = of;
    double force_N = s[filter_output];
    if (samples_within_) {
        force_N = 0.0;
        for (std::size_t row = 0; row < s.size(); row++) {
            force_N += sample_[row] * s[row];
        }
        for (std::size_t i = 0; i < of_position_.size(); i++) {
            force_N += sample_[static_cast<std::size_t>(positions) + i] * position_m[i];
        }
    }
    /* The state comes last: what the robot does need not wait for the tick before. */
    state next{};
    for (std::size_t i = 0; i < of_position_.size(); i++) {
        for (std::size_t row = 0; row < s.size(); row++) {
            next[row] += of_position_[i][row] * position_m[i];
        }
    }
    for (std::size_t i = 0; bulge_m != nullptr && i < of_bulge_.size(); i++) {
        if (bulge_m[i] != 0.0) { /* few ticks have a corner */
            force_N += samples_within_
                           ? sample_[static_cast<std::size_t>(positions) + of_position_.size() + i] * bulge_m[i]
                           : 0.0;
            for (std::size_t row = 0; row < s.size(); row++) {
                next[row] += of_bulge_[i][row] * bulge_m[i];
            }
        }
    }
    for (std::size_t column = 0; column < s.size(); column++) {
        for (std::size_t row = 0; row < s.size(); row++) {
            next[row] += of_state_[column][row] * s[column];
        }
    }
    of = next;
    return force_N;
}

} // namespace berth
