#include "dominant_root.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <limits>
#include <optional>

#include "../solver/balance.h"
#include "../solver/decompositions.h"
#include "zero_count.h"

namespace berth
{

namespace
{

using complex = std::complex<double>;

constexpr int newton_steps_max = 12;

/* Newton's error is squared from step to step: after one of this size nothing is left but rounding. */
constexpr double last_step = 3e-8;

/* The proof leaves this much room to the root itself: zeros nearer than this to the circle count as the same. */
constexpr double circle_margin = 1e-10;

/* Up to these degrees all roots at once are the cheaper search, and the Schur-Cohn recursion the cheaper proof. */
constexpr int companion_degree_max = 64;
constexpr int schur_cohn_degree_max = 160;

/* Returns F' at the root, 0 if there was none near. */
complex newton(const loop_equation &equation, complex &w)
{
    for (int i = 0; i < newton_steps_max; i++) {
        const equation_value f = evaluate(equation, w);
        const complex step = f.value / f.slope;
        w -= step;
        if (std::norm(step) <= last_step * last_step * std::norm(w)) {
            w = {w.real(), std::abs(w.imag())};
            return f.slope;
        }
    }
    return 0.0;
}

/* From the turning point of L = w^delay B/A to near the zero where L = -1: on the logarithm, which the long power
 * makes straight. */
complex towards_zero(const loop_equation &equation, complex w)
{
    for (int i = 0; i < 6; i++) {
        const equation_parts p = evaluate_parts(equation, w);
        const complex log_loop = static_cast<double>(equation.delay) * std::log(w) + std::log(-p.b / p.a);
        const double turn = 6.28318530717958647692;
        const complex rest(log_loop.real(), std::remainder(log_loop.imag(), turn));
        const complex step = rest / (static_cast<double>(equation.delay) / w + p.b_slope / p.b - p.a_slope / p.a);
        w -= step;
        if (!(std::norm(step) > 1e-10 * std::norm(w))) {
            break;
        }
    }
    return w;
}

using coefficients = std::array<double, schur_cohn_degree_max + 2>;

/* Coefficients of F(radius w) by rising powers, with one place more; returns the sum of their magnitudes. */
double expand(const loop_equation &equation, double radius, double *c)
{
    const int degree = equation.degree();
    std::fill(c, c + degree + 1, 0.0);
    for (int i = 0; i <= equation.a.degree; i++) {
        c[i] += equation.a.coefficients[static_cast<std::size_t>(i)];
    }
    for (int i = 0; i <= equation.b.degree; i++) {
        c[equation.delay + i] += equation.b.coefficients[static_cast<std::size_t>(i)];
    }
    double sum = 0.0;
    double even = 1.0;
    double odd = radius;
    c[degree + 1] = 0.0; /* so that pairs come out even */
    for (int i = 0; i <= degree; i += 2) {
        c[i] *= even;
        c[i + 1] *= odd;
        even *= radius * radius;
        odd *= radius * radius;
        sum += std::abs(c[i]) + std::abs(c[i + 1]);
    }
    return sum;
}

/* All zeros outside the unit circle: every reflection |c_n / c_0| of the Schur-Cohn recursion is below 1. Two at a
 * time, so that one division does not have to wait for the other. */
bool schur_cohn_outside(double *c, int degree)
{
    coefficients second;
    double *from = c;
    double *to = second.data();
    int n = degree;
    for (; n > 1; n -= 2, std::swap(from, to)) {
        const double k = from[n] / from[0];
        const double l = (from[n - 1] * from[0] - from[n] * from[1]) / (from[0] * from[0] - from[n] * from[n]);
        if (!(std::abs(k) < 1.0 && std::abs(l) < 1.0)) {
            return false;
        }
        const double kl = k * l;
        const double *const back = from + n;
        for (int i = 0; i <= n - 2; i++) {
            to[i] = (from[i] - k * back[-i]) - (l * back[-i - 1] - kl * from[i + 1]);
        }
    }
    return n == 0 || std::abs(from[1]) < std::abs(from[0]);
}

/* A circle just inside a zero. */
double radius_below(complex w)
{
    return std::sqrt(std::norm(w)) * (1.0 - circle_margin);
}

/* Whether no zero is smaller than this one, where F has the slope F'; nothing where the recursion does not pay or is
 * not exact enough. */
std::optional<bool> is_smallest_by_recursion(const loop_equation &equation, complex w, complex slope)
{
    if (equation.degree() > schur_cohn_degree_max) {
        return {};
    }
    coefficients c;
    const double sum = expand(equation, radius_below(w), c.data());
    /* Multiplying out must not have moved the zero by as much as the margin. */
    const double shift = 1e-16 * sum / std::sqrt(std::norm(slope) * std::norm(w));
    return shift < 0.1 * circle_margin ? std::optional(schur_cohn_outside(c.data(), equation.degree()))
                                       : std::nullopt;
}

/* 1/z of every eigenvalue of the companion matrix in the upper half plane. */
std::vector<complex> all_roots(const loop_equation &equation)
{
    std::vector<double> c(static_cast<std::size_t>(equation.degree()) + 2);
    expand(equation, 1.0, c.data());
    c.pop_back();
    while (c.size() > 2 && c.back() == 0.0) {
        c.pop_back();
    }
    const auto n = static_cast<Eigen::Index>(c.size()) - 1;
    Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
    companion.bottomLeftCorner(n - 1, n - 1).setIdentity();
    for (Eigen::Index i = 0; i < n; i++) {
        companion(0, i) = -c[static_cast<std::size_t>(i) + 1] / c[0];
    }
    balance(companion);
    std::vector<complex> roots;
    for (const complex z : eigenvalues(companion)) {
        if (z.imag() >= 0.0 && z != 0.0) {
            roots.push_back(1.0 / z);
        }
    }
    return roots;
}

bool is_smaller(complex a, complex b)
{
    return std::norm(a) < std::norm(b);
}

/* Newton's method from each; sorted, each zero once. A slow pair that rounding has split into two real starts is not
 * to be reached along the real axis. */
std::vector<complex> polished(const loop_equation &equation, const std::vector<complex> &starts)
{
    std::vector<complex> roots;
    for (const complex start : starts) {
        complex w = start;
        complex off_axis = start + complex(0.0, std::abs(1.0 - start));
        if (newton(equation, w) != 0.0) {
            roots.push_back(w);
        } else if (start.imag() == 0.0 && newton(equation, off_axis) != 0.0) {
            roots.push_back(off_axis);
        }
    }
    std::sort(roots.begin(), roots.end(), is_smaller);
    const auto is_same = [](complex a, complex b) { return std::norm(a - b) <= 1e-18 * std::norm(a); };
    roots.erase(std::unique(roots.begin(), roots.end(), is_same), roots.end());
    return roots;
}

/* Zeros inside and near the circle, by way of the turns of L on it, and of the poles that the loop hardly moves. */
std::vector<complex> roots_near(const loop_equation &equation, double radius, int *count)
{
    std::vector<complex> starts;
    *count = count_zeros_inside(equation, radius, &starts);
    for (complex &w : starts) {
        w = towards_zero(equation, w);
    }
    for (int i = 0; i < equation.a_factor_count; i++) {
        for (const complex pole : roots_of(equation.a_factors[static_cast<std::size_t>(i)])) {
            if (std::abs(pole) < 2.0 && pole.imag() >= 0.0) {
                starts.push_back(pole);
            }
        }
    }
    return polished(equation, starts);
}

/* The smallest zeros, the first of them proved to be the smallest; empty if that did not succeed. */
std::vector<complex> search_by_circles(const loop_equation &equation)
{
    constexpr int rounds_max = 400;
    const double wider = 1.0 + 6.0 / equation.degree();
    double radius = 1.0;
    std::vector<complex> roots;
    int count = 0;
    for (int i = 0; i < rounds_max; i++) {
        std::vector<complex> found = roots_near(equation, radius, &count);
        const bool found_smaller = !found.empty() && (roots.empty() || is_smaller(found[0], roots[0]));
        if (count == 0 && !roots.empty()) {
            return roots;
        }
        if (count > 0 && !found_smaller) {
            return {};
        }
        if (count > 0) {
            roots = std::move(found);
            radius = radius_below(roots[0]);
        } else {
            radius *= wider;
        }
    }
    return {};
}

} // namespace

bool has_no_zero_inside(const loop_equation &equation, double radius)
{
    return count_zeros_inside(equation, radius) == 0;
}

/* The mode that led before, from where a cubic through its last places says that it is. */
bool dominant_root_finder::follow(const loop_equation &equation)
{
    if (followed_count_ == 0) {
        return false;
    }
    complex w = followed_[0];
    if (before_count_ == 3) {
        w = 4.0 * (followed_[0] + before_[1]) - 6.0 * before_[0] - before_[2];
    } else if (before_count_ == 2) {
        w = 3.0 * (followed_[0] - before_[0]) + before_[1];
    } else if (before_count_ == 1) {
        w = 2.0 * followed_[0] - before_[0];
    }
    const complex slope = newton(equation, w);
    if (slope == 0.0) {
        return false;
    }
    const std::optional<bool> is_smallest = is_smallest_by_recursion(equation, w, slope);
    if (is_smallest ? !*is_smallest : !has_no_zero_inside(equation, radius_below(w))) {
        return false;
    }
    before_ = {followed_[0], before_[0], before_[1]};
    before_count_ = std::min(before_count_ + 1, 3);
    followed_[0] = w;
    return true;
}

/* One of the modes that came behind it, or one that the turns of L on the circle of the smallest give away. */
bool dominant_root_finder::follow_others(const loop_equation &equation)
{
    std::vector<complex> roots = polished(equation, {followed_.begin(), followed_.begin() + followed_count_});
    for (int i = 0; i < followed_max && !roots.empty(); i++) {
        const complex slope = evaluate(equation, roots[0]).slope;
        if (is_smallest_by_recursion(equation, roots[0], slope).value_or(false)) {
            keep(roots);
            return true;
        }
        int count = 0;
        const std::vector<complex> found = roots_near(equation, radius_below(roots[0]), &count);
        if (count == 0) {
            keep(roots);
            return true;
        }
        if (found.empty() || !is_smaller(found[0], roots[0])) {
            return false;
        }
        roots.insert(roots.begin(), found[0]);
    }
    return false;
}

void dominant_root_finder::keep(const std::vector<complex> &roots)
{
    followed_count_ = std::min(followed_max, static_cast<int>(roots.size()));
    std::copy(roots.begin(), roots.begin() + followed_count_, followed_.begin());
    before_count_ = 0;
}

double dominant_root_finder::spectral_radius(const loop_equation &equation)
{
    if (!follow(equation) && !follow_others(equation)) {
        searches_++;
        std::vector<complex> roots;
        if (equation.degree() > companion_degree_max) {
            roots = search_by_circles(equation);
        }
        if (roots.empty()) {
            const std::vector<complex> all = all_roots(equation);
            roots = polished(equation, all);
            if (all.empty()) {
                return std::numeric_limits<double>::quiet_NaN(); /* coefficients beyond all numbers */
            }
            if (roots.empty() || !has_no_zero_inside(equation, radius_below(roots[0]))) {
                const std::vector<complex> proved = search_by_circles(equation);
                roots = proved.empty() ? roots : proved;
            }
            if (roots.empty()) {
                roots = {*std::min_element(all.begin(), all.end(), is_smaller)};
            }
        }
        keep(roots);
    }
    return 1.0 / std::sqrt(std::norm(followed_[0]));
}

} // namespace berth
