#include "dominant_root.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <vector>

#include "../solver/balance.h"

namespace berth
{

namespace
{

constexpr int newton_steps_max = 12;

/* Newton's error is squared from step to step: after one of this size the next is rounding. */
constexpr double last_step = 1e-7;

/* The proof leaves this much room to the root itself: zeros nearer than this to the circle count as the same. */
constexpr double circle_margin = 1e-9;

/* Up to this degree the Schur-Cohn recursion is the cheaper proof, beyond it the winding number. */
constexpr int schur_cohn_degree_max = 64;

bool newton(const loop_equation &equation, std::complex<double> &w)
{
    for (int i = 0; i < newton_steps_max; i++) {
        const equation_value f = evaluate(equation, w);
        const std::complex<double> step = f.value / f.slope;
        w -= step;
        if (std::abs(step) <= last_step * std::abs(w)) {
            const equation_value at_root = evaluate(equation, w);
            w -= at_root.value / at_root.slope;
            return true;
        }
    }
    return false;
}

/* Coefficients of F(radius w) by rising powers. */
void expand(const loop_equation &equation, double radius, std::vector<double> &c)
{
    c.assign(static_cast<std::size_t>(equation.degree()) + 1, 0.0);
    for (int i = 0; i <= equation.a.degree; i++) {
        c[static_cast<std::size_t>(i)] += equation.a.coefficients[static_cast<std::size_t>(i)];
    }
    for (int i = 0; i <= equation.b.degree; i++) {
        c[static_cast<std::size_t>(equation.delay + i)] += equation.b.coefficients[static_cast<std::size_t>(i)];
    }
    double power = 1.0;
    for (double &coefficient : c) {
        coefficient *= power;
        power *= radius;
    }
}

/* All zeros outside the unit circle: every reflection |c_n / c_0| of the Schur-Cohn recursion is below 1. */
bool schur_cohn_outside(std::vector<double> &c)
{
    for (std::size_t n = c.size() - 1; n > 0; n--) {
        const double k = c[n] / c[0];
        if (!(std::abs(k) < 1.0)) {
            return false;
        }
        for (std::size_t i = 0; 2 * i <= n; i++) {
            const double low = c[i];
            const double high = c[n - i];
            c[i] = low - k * high;
            c[n - i] = high - k * low;
        }
    }
    return true;
}

/* Turns of F along the upper half of the circle, in steps that turn it by less than a quarter. */
bool winds_not(const loop_equation &equation, double radius)
{
    constexpr double pi = 3.14159265358979323846;
    constexpr double step_least = 1e-9;
    double angle = 0.0;
    double step = 0.5 / (equation.degree() + 1.0);
    double turned = 0.0;
    std::complex<double> before = evaluate(equation, radius).value;
    while (angle < pi) {
        const double next = std::min(pi, angle + step);
        const std::complex<double> after = evaluate(equation, std::polar(radius, next)).value;
        const double turn = std::arg(after / before);
        if (std::abs(turn) > 0.8 && step > step_least) {
            step *= 0.5;
            continue;
        }
        turned += turn;
        angle = next;
        before = after;
        step *= std::abs(turn) < 0.3 ? 2.0 : 1.0;
    }
    return std::abs(turned) < pi / 2.0;
}

} // namespace

bool has_no_zero_inside(const loop_equation &equation, double radius)
{
    if (equation.degree() > schur_cohn_degree_max) {
        return winds_not(equation, radius);
    }
    thread_local std::vector<double> coefficients;
    expand(equation, radius, coefficients);
    return schur_cohn_outside(coefficients);
}

bool dominant_root_finder::follow(const loop_equation &equation)
{
    for (int i = 0; i < followed_count_; i++) {
        if (!newton(equation, followed_[static_cast<std::size_t>(i)])) {
            return false;
        }
    }
    std::sort(followed_.begin(), followed_.begin() + followed_count_,
              [](const auto &a, const auto &b) { return std::abs(a) < std::abs(b); });
    return followed_count_ > 0 && has_no_zero_inside(equation, std::abs(followed_[0]) * (1.0 - circle_margin));
}

void dominant_root_finder::solve_fully(const loop_equation &equation)
{
    full_solutions_++;
    std::vector<double> c;
    expand(equation, 1.0, c);
    while (c.size() > 2 && c.back() == 0.0) {
        c.pop_back();
    }
    /* Companion matrix in z: its eigenvalues are 1/w. */
    const auto n = static_cast<Eigen::Index>(c.size()) - 1;
    Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
    companion.bottomLeftCorner(n - 1, n - 1).setIdentity();
    for (Eigen::Index i = 0; i < n; i++) {
        companion(0, i) = -c[static_cast<std::size_t>(i) + 1] / c[0];
    }
    balance(companion);
    const Eigen::VectorXcd all = companion.eigenvalues();
    std::vector<std::complex<double>> upper;
    for (const std::complex<double> z : all) {
        if (z.imag() >= 0.0 && z != 0.0) {
            upper.push_back(1.0 / z);
        }
    }
    std::sort(upper.begin(), upper.end(), [](const auto &a, const auto &b) { return std::abs(a) < std::abs(b); });
    followed_count_ = std::min(followed_max, static_cast<int>(upper.size()));
    for (int i = 0; i < followed_count_; i++) {
        followed_[static_cast<std::size_t>(i)] = upper[static_cast<std::size_t>(i)];
        newton(equation, followed_[static_cast<std::size_t>(i)]);
    }
}

double dominant_root_finder::spectral_radius(const loop_equation &equation)
{
    if (!follow(equation)) {
        solve_fully(equation);
    }
    return 1.0 / std::abs(followed_[0]);
}

} // namespace berth
