/* The manipulator's block: windows that each start anew, from the state that fits them best. */
#include <cmath>
#include <Eigen/QR>

#include "../effects/active.h"
#include "../solver/decompositions.h"
#include "block_model.h"

namespace berth
{

namespace
{

/* What would leave the range of the record belongs to a replay that has run away. */
void add_to(std::vector<Eigen::Vector2d> &starts, const std::vector<Eigen::Vector2d> &off, double range_m)
{
    for (std::size_t i = 0; i < starts.size(); i++) {
        if (std::abs(off[i](0)) < range_m && std::isfinite(off[i](1))) {
            starts[i] += off[i];
        }
    }
}

/* Each is no larger than the other, or hardly. */
bool all_nearly(const std::vector<double> &squares, const std::vector<double> &others)
{
    constexpr double hardly = 1.02;
    for (std::size_t i = 0; i < squares.size(); i++) {
        if (squares[i] > hardly * others[i]) {
            return false;
        }
    }
    return true;
}

} // namespace

/* What a window's start explains is linear in it only for a linear manipulator. With effects on it: from the start
 * that suits the linear one, how the replay itself follows position and velocity of the start, until nothing more is
 * to be gained. In the short windows of one without a spring friction turns with a start that encoder steps decide:
 * there the linear way is the truer one (friction of the EMPS benchmark within 1 % rather than 4 %). */
void block_model::replay_windows(const rig &rig, std::vector<double> &error)
{
    replay_manipulator(rig, record_, windows_, starts_, simulated_);
    compare(simulated_, error);
    const std::vector<Eigen::Vector2d> off = remove_starts(rig, error);
    if (active_stages(rig, &effect::on_body, "manipulator").empty()) {
        return;
    }
    std::vector<Eigen::Vector2d> starts = starts_;
    add_to(starts, off, range_m_);
    std::vector<double> at_start;
    replay_manipulator(rig, record_, windows_, starts, at_start);
    compare(at_start, error);
    const bool has_spring = rows_per_fact_ == 1.0;
    if (!has_spring) {
        remove_starts(rig, error);
        return;
    }
    constexpr int rounds_max = 4;
    for (int round = 0; round < rounds_max; round++) {
        const std::vector<double> before = squares_of_windows(error);
        follow_starts(rig, starts, at_start);
        add_to(starts, remove_followed(error), range_m_);
        const bool is_there = all_nearly(before, squares_of_windows(error));
        replay_manipulator(rig, record_, windows_, starts, at_start);
        compare(at_start, error);
        if (is_there) {
            break;
        }
    }
    remove_followed(error);
}

/* Differences of the replay by position and velocity of each window's start. */
void block_model::follow_starts(const rig &rig, const std::vector<Eigen::Vector2d> &starts,
                                const std::vector<double> &at_start)
{
    for (int i = 0; i < 2; i++) {
        const double step = 1e-4 * range_m_ * (i == 0 ? 1.0 : 0.01 / record_.period_s);
        std::vector<Eigen::Vector2d> aside = starts;
        for (Eigen::Vector2d &start : aside) {
            start(i) += step;
        }
        replay_manipulator(rig, record_, windows_, aside, followed_[i]);
        for (std::size_t n = 0; n < at_start.size(); n++) {
            followed_[i][n] = (followed_[i][n] - at_start[n]) / step;
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

std::vector<Eigen::Vector2d> block_model::remove_followed(std::vector<double> &error) const
{
    std::vector<Eigen::Vector2d> off;
    off.reserve(windows_.size());
    for (const record_segment &window : windows_) {
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
        const Eigen::HouseholderQR<Eigen::MatrixXd> qr(basis);
        off.emplace_back(qr.solve(part));
        part -= basis * off.back();
    }
    return off;
}

} // namespace berth
