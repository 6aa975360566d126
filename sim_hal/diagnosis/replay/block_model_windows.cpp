/* The manipulator's block: windows that each start anew, from the state that fits them best. */
#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <iterator>
#include <numeric>

#include "../../effects/active.h"
#include "../../solver/decompositions.h"
#include "../record/record_gaps.h"
#include "block_model.h"

namespace berth
{

namespace
{

/* What would leave the range of the record belongs to a replay that has run away. */
void add_to(std::vector<Eigen::Vector2d> &starts, const std::vector<Eigen::Vector2d> &off,
            const std::vector<std::size_t> &windows, double range_m)
{
    for (std::size_t i = 0; i < windows.size(); i++) {
        if (std::abs(off[i](0)) < range_m && std::isfinite(off[i](1))) {
            starts[windows[i]] += off[i];
        }
    }
}

/* Those of some windows. */
template <class value>
std::vector<value> picked(const std::vector<value> &of_all, const std::vector<std::size_t> &windows)
{
    std::vector<value> some;
    some.reserve(windows.size());
    std::transform(windows.begin(), windows.end(), std::back_inserter(some),
                   [&](std::size_t window) { return of_all[window]; });
    return some;
}

} // namespace

std::size_t rows_that_show_acceleration(const record &record, std::size_t rows_max)
{
    constexpr std::size_t least = 12; /* rows */
    constexpr std::size_t apart = 6;  /* rows, of the differences that show the acceleration */
    constexpr double resolved = 1e-3; /* of its rms: a friction of a hundredth of it is ten times that */
    const std::vector<double> &x = record.command_position_m;
    double thirds = 0.0;  /* squares of third differences of neighbours: 20 times the variance of the noise */
    double seconds = 0.0; /* of second ones of rows apart: the motion, and 6 times that variance */
    double rows = 0.0;
    for (const record_segment &part : record.segments) {
        for (std::size_t n = part.begin + apart; n + apart < part.end; n++) {
            thirds += std::pow(x[n + 1] - 3.0 * x[n] + 3.0 * x[n - 1] - x[n - 2], 2) / 20.0;
            seconds += std::pow(x[n + apart] - 2.0 * x[n] + x[n - apart], 2);
            rows += 1.0;
        }
    }
    const double noise_m = std::sqrt(thirds / std::max(1.0, rows));
    const double moved_m = std::sqrt(std::max(0.0, seconds - 6.0 * thirds) / std::max(1.0, rows));
    const double a_period_m = moved_m / static_cast<double>(apart * apart); /* acceleration times its square */
    std::size_t length = least;
    /* Of a parabola through so many evenly spaced rows the acceleration is known to noise sqrt(720 / rows^5). */
    while (length + least <= rows_max &&
           noise_m * std::sqrt(720.0 / std::pow(static_cast<double>(length), 5)) > resolved * a_period_m) {
        length += least;
    }
    return length;
}

/* What a window's start explains is linear in it only for a linear manipulator. With effects on it: from the start
 * that suits the linear one, how the replay itself follows position and velocity of the start, until nothing more is
 * to be gained. In the short windows of one without a spring friction turns with a start that encoder steps decide:
 * there the linear way is the truer one (friction of the EMPS benchmark within 1 % rather than 4 %). */
void block_model::replay_windows(const rig &rig, std::vector<double> &error)
{
    found_starts_.clear();
    replay_manipulator(rig, record_, windows_, starts_, simulated_);
    compare(simulated_, error);
    const std::vector<Eigen::Vector2d> off = remove_starts(rig, error);
    if (active_stages(rig, &effect::on_body, "manipulator").empty()) {
        return;
    }
    std::vector<Eigen::Vector2d> starts = starts_;
    std::vector<std::size_t> open = all_windows();
    add_to(starts, off, open, range_m_);
    std::vector<double> at_start;
    replay_manipulator(rig, record_, windows_, starts, at_start);
    compare(at_start, error);
    const bool has_spring = true;
    if (!has_spring) {
        remove_starts(rig, error);
        return;
    }
    constexpr int rounds_max = 4;
    constexpr double hardly = 1.02; /* times smaller */
    for (int round = 0; round < rounds_max && !open.empty(); round++) {
        const std::vector<double> before = squares_of_windows(error);
        follow_starts(rig, starts, open, at_start);
        add_to(starts, remove_followed(error, open), open, range_m_);
        const std::vector<double> after = squares_of_windows(error);
        replay_manipulator(rig, record_, picked(windows_, open), picked(starts, open), at_start);
        compare(at_start, error);
        open.erase(
            std::remove_if(open.begin(), open.end(), [&](std::size_t i) { return before[i] <= hardly * after[i]; }),
            open.end());
    }
    remove_followed(error, all_windows());
    found_starts_ = std::move(starts);
}

std::vector<std::size_t> block_model::all_windows() const
{
    std::vector<std::size_t> all(windows_.size());
    std::iota(all.begin(), all.end(), 0U);
    return all;
}

/* Differences of the replay by position and velocity of the starts of some windows. */
void block_model::follow_starts(const rig &rig, const std::vector<Eigen::Vector2d> &starts,
                                const std::vector<std::size_t> &open, const std::vector<double> &at_start)
{
    const std::vector<record_segment> windows = picked(windows_, open);
    for (int i = 0; i < 2; i++) {
        const double step = 1e-4 * range_m_ * (i == 0 ? 1.0 : 0.01 / record_.period_s);
        std::vector<Eigen::Vector2d> aside = picked(starts, open);
        for (Eigen::Vector2d &start : aside) {
            start(i) += step;
        }
        replay_manipulator(rig, record_, windows, aside, followed_[i]);
        for (const record_segment &window : windows) {
            for (std::size_t n = window.begin; n < window.end; n++) {
                followed_[i][n] = (followed_[i][n] - at_start[n]) / step;
            }
        }
    }
}

std::vector<double> block_model::squares_of_windows(const std::vector<double> &error) const
{
    std::vector<double> squares(windows_.size(), 0.0);
    for (std::size_t i = 0; i < windows_.size(); i++) {
        for (std::size_t n = windows_[i].begin; n < windows_[i].end; n++) {
            squares[i] += error[n] * error[n];
        }
    }
    return squares;
}

std::vector<Eigen::Vector2d> block_model::remove_followed(std::vector<double> &error,
                                                          const std::vector<std::size_t> &windows) const
{
    std::vector<Eigen::Vector2d> off;
    off.reserve(windows.size());
    for (const std::size_t at : windows) {
        const record_segment &window = windows_[at];
        const auto count = static_cast<Eigen::Index>(window.end - window.begin);
        Eigen::MatrixXd basis(count, 2);
        for (int i = 0; i < 2; i++) {
            basis.col(i) = Eigen::Map<const Eigen::VectorXd>(followed_[i].data() + window.begin, count);
        }
        Eigen::Map<Eigen::VectorXd> part(error.data() + window.begin, count);
        off.emplace_back(least_squares_solution(basis, part));
        part -= basis * off.back();
    }
    return off;
}

/* A window's first position and velocity are known badly: what they explain is taken out, by least squares. */
std::vector<Eigen::Vector2d> block_model::remove_starts(const rig &rig, std::vector<double> &error) const
{
    const manipulator_config &config = rig.firmware.manipulator;
    Eigen::Matrix2d a;
    const double h = record_.period_s;
    a << 0.0, 1.0, -config.stiffness_N_per_m / config.mass_kg, -config.damping_N_s_per_m / config.mass_kg;
    Eigen::Matrix2d transition = Eigen::Matrix2d::Identity();
    Eigen::Matrix2d term = Eigen::Matrix2d::Identity();
    for (int i = 1; i < 24; i++) { /* a period is short against the manipulator's own */
        term = (term * a * h / i).eval();
        transition += term;
    }
    std::vector<Eigen::Vector2d> off;
    off.reserve(windows_.size());
    for (const record_segment &window : windows_) {
        const auto count = static_cast<Eigen::Index>(window.end - window.begin);
        Eigen::MatrixXd basis(count, 2);
        Eigen::Matrix2d power = Eigen::Matrix2d::Identity();
        for (Eigen::Index n = 0; n < count; n++) {
            basis.row(n) = power.row(0);
            power = (transition * power).eval();
        }
        Eigen::Map<Eigen::VectorXd> part(error.data() + window.begin, count);
        off.emplace_back(full_rank_least_squares(basis, part));
        part -= basis * off.back();
    }
    return off;
}

/* Between rows that are missing: a force that is guessed would be integrated. */
void block_model::add_windows(const record_segment &segment, std::size_t length)
{
    for (const record_segment &known : known_stretches(record_, segment)) {
        std::size_t begin = known.begin;
        while (begin < known.end) {
            /* What would be left over at the end goes with the last one. */
            const std::size_t end = begin + 2 * length > known.end ? known.end : begin + length;
            windows_.push_back({begin, end});
            begin = end;
        }
    }
}

} // namespace berth
