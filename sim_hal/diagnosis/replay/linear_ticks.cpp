#include "linear_ticks.h"

#include <algorithm>
#include <Eigen/Core>

namespace berth
{

namespace
{

constexpr auto body_rows = static_cast<Eigen::Index>(object_steps::rows);

template <std::size_t rows>
using columns_of = Eigen::Matrix<double, static_cast<Eigen::Index>(rows), Eigen::Dynamic>;

template <std::size_t size>
Eigen::Map<const Eigen::Matrix<double, static_cast<Eigen::Index>(size), 1>>
as_vector(const std::array<double, size> &column)
{
    return Eigen::Map<const Eigen::Matrix<double, static_cast<Eigen::Index>(size), 1>>(column.data());
}

/* What a further force does to the state at the end of a step that was taken without it. */
void push_by(const linear_law &law, const object_steps::step_map &map,
             columns_of<object_steps::rows + linear_law::kept> &made)
{
    constexpr auto kept = static_cast<Eigen::Index>(linear_law::kept);
    Eigen::Matrix<double, kept + 1, kept + 1> step;
    for (std::size_t i = 0; i < law.column.size(); i++) {
        step.col(static_cast<Eigen::Index>(i)) = as_vector(law.column[i]);
    }
    columns_of<linear_law::kept + 1> from(kept + 1, made.cols());
    from << made.bottomRows<kept>(), made.row(object_velocity);
    const columns_of<linear_law::kept + 1> after = step * from;
    made.bottomRows<kept>() = after.topRows<kept>();
    made.topRows<body_rows>() += as_vector(map.column[object_steps::columns - 1]) * after.row(kept);
}

/* Step number `number` of `count` after those in `so_far`: columns of (state, positions, bulges of the steps). A
 * gripped object is at rest at 0: no constant. */
template <std::size_t rows>
columns_of<rows> with_step(const columns_of<rows> &so_far, const object_steps::step_map &map, double step_s,
                           Eigen::Index number, Eigen::Index count)
{
    constexpr auto positions = static_cast<Eigen::Index>(rows);
    Eigen::Matrix<double, body_rows, body_rows> transition;
    for (std::size_t i = 0; i < object_steps::rows; i++) {
        transition.col(static_cast<Eigen::Index>(i)) = as_vector(map.column[i]);
    }
    const Eigen::Matrix<double, body_rows, 1> by_rise = as_vector(map.column[object_steps::rows + 1]) / step_s;
    columns_of<rows> made = so_far;
    auto body = made.template topRows<body_rows>();
    body = transition * so_far.template topRows<body_rows>();
    const auto by_position = as_vector(map.column[object_steps::rows]);
    body.col(positions + number) += by_position - by_rise;
    body.col(positions + number + 1) += by_rise;
    body.col(positions + count + 1 + number) +=
        6.0 * by_rise - 12.0 / (step_s * step_s) * as_vector(map.column[object_steps::rows + 2]);
    return made;
}

template <std::size_t rows>
std::array<double, rows> as_state(const columns_of<rows> &all, Eigen::Index column)
{
    std::array<double, rows> made{};
    Eigen::Map<Eigen::Matrix<double, static_cast<Eigen::Index>(rows), 1>>(made.data()) = all.col(column);
    return made;
}

} // namespace

template <std::size_t kept>
typename linear_ticks<kept>::state linear_ticks<kept>::at_rest(const object_steps &object)
{
    state made{};
    std::copy(object.state().begin(), object.state().end(), made.begin());
    return made;
}

template <std::size_t kept>
linear_ticks<kept>::linear_ticks(const object_steps &object, const tick_steps &tick,
                                 const std::vector<object_steps::step_maps> &maps)
    : samples_within_(tick.sample_after > 0)
{
    constexpr auto positions = static_cast<Eigen::Index>(rows);
    const auto count = static_cast<Eigen::Index>(tick.count());
    columns_of<rows> all = columns_of<rows>::Zero(positions, positions + count + 1 + count);
    all.template leftCols<positions>().setIdentity();
    for (std::size_t step = 0; step < tick.count(); step++) {
        if (samples_within_ && step == tick.sample_after) {
            const Eigen::VectorXd force = all.row(filter_output);
            sample_.assign(force.data(), force.data() + force.size());
        }
        const auto &map = maps[tick.kind[step]][static_cast<std::size_t>(object_steps::grip::holds)];
        all = with_step<rows>(all, map, tick.duration_s[step], static_cast<Eigen::Index>(step), count);
        if constexpr (kept > 0) {
            push_by(object.further_law(map, tick.duration_s[step]), map, all);
        }
    }
    for (std::size_t i = 0; i < rows; i++) {
        of_state_[i] = as_state<rows>(all, static_cast<Eigen::Index>(i));
    }
    for (Eigen::Index i = 0; i <= count; i++) {
        of_position_.push_back(as_state<rows>(all, positions + i));
    }
    for (Eigen::Index i = 0; i < count; i++) {
        of_bulge_.push_back(as_state<rows>(all, positions + count + 1 + i));
    }
}

template <std::size_t kept>
double linear_ticks<kept>::advance(state &of, const double *position_m, const double *bulge_m) const
{
    const state s = of;
    double force_N = s[filter_output];
    if (samples_within_) {
        force_N = 0.0;
        for (std::size_t row = 0; row < s.size(); row++) {
            force_N += sample_[row] * s[row];
        }
        for (std::size_t i = 0; i < of_position_.size(); i++) {
            force_N += sample_[rows + i] * position_m[i];
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
            force_N += samples_within_ ? sample_[rows + of_position_.size() + i] * bulge_m[i] : 0.0;
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

template class linear_ticks<0>;
template class linear_ticks<linear_law::kept>;

} // namespace berth
