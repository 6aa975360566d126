#include <doctest/doctest.h>

#include <cmath>

#include <Eigen/Core>

#include "../../firmware/pi.h"
#include "seeded.h"
#include "sim_hal/diagnosis/fit/least_squares.h"
#include "sim_hal/solver/factors.h"

namespace
{

using Eigen::MatrixXd;
using Eigen::VectorXd;

double model_value(const MatrixXd &h, const VectorXd &g, const VectorXd &s)
{
    return 0.5 * s.dot(h * s) + g.dot(s);
}

/* Every variable free, at its low or at its high bound: the best of the feasible ones. */
VectorXd best_of_all_places(const MatrixXd &h, const VectorXd &g, const VectorXd &low, const VectorXd &high)
{
    const Eigen::Index size = g.size();
    VectorXd best;
    const int all = static_cast<int>(std::lround(std::pow(3.0, static_cast<double>(size))));
    for (int code = 0; code < all; code++) {
        MatrixXd a = h;
        VectorXd b = -g;
        int left = code;
        for (Eigen::Index i = 0; i < size; i++, left /= 3) {
            if (left % 3 != 0) {
                a.row(i).setZero();
                a(i, i) = 1.0;
                b(i) = left % 3 == 1 ? low(i) : high(i);
            }
        }
        const VectorXd s = berth::solution(a, b);
        const bool is_feasible = (s - low).minCoeff() > -1e-9 && (high - s).minCoeff() > -1e-9;
        if (is_feasible && (best.size() == 0 || model_value(h, g, s) < model_value(h, g, best))) {
            best = s;
        }
    }
    return best;
}

berth::least_squares_problem boxed(Eigen::Index size, double low, double high)
{
    berth::least_squares_problem task;
    task.low = VectorXd::Constant(size, low);
    task.high = VectorXd::Constant(size, high);
    task.step = VectorXd::Constant(size, 1e-6);
    task.tolerance = 1e-12;
    task.evaluations_max = 400;
    return task;
}

} // namespace

TEST_CASE("least squares: the bounded step is the best of all choices of bounds")
{
    SEEDED(random, "least squares: the bounded step*");
    for (int i = 0; i < 200; i++) {
        const Eigen::Index size = 1 + i % 5;
        const MatrixXd root = MatrixXd::NullaryExpr(size, size, [&] { return seeded::uniform(random, -1.0, 1.0); });
        const MatrixXd h = root.transpose() * root + 0.05 * MatrixXd::Identity(size, size);
        const VectorXd g = VectorXd::NullaryExpr(size, [&] { return seeded::uniform(random, -1.0, 1.0); });
        const VectorXd low = VectorXd::NullaryExpr(size, [&] { return seeded::uniform(random, -1.0, 0.0); });
        const VectorXd high = VectorXd::NullaryExpr(size, [&] { return seeded::uniform(random, 0.0, 1.0); });
        const VectorXd expected = best_of_all_places(h, g, low, high);
        const VectorXd found = berth::bounded_step(h, g, low, high);
        CHECK((found - expected).norm() < 1e-7);
    }
}

TEST_CASE("least squares: Rosenbrock's valley, free and with a bound across it")
{
    for (const double high : {4.0, 0.5}) {
        berth::least_squares_problem task = boxed(2, -2.0, high);
        task.residual = [](const VectorXd &x, VectorXd &r) {
            r.resize(2);
            r << 10.0 * (x(1) - x(0) * x(0)), 1.0 - x(0);
        };
        const auto found = berth::solve_least_squares(task, (VectorXd(2) << -1.2, 0.4).finished());
        /* x <= 0.5: then y = x^2 is free, and x is as large as it may be. */
        const double x = std::min(1.0, high);
        CHECK(found.x(0) == doctest::Approx(x).epsilon(1e-6));
        CHECK(found.x(1) == doctest::Approx(x * x).epsilon(1e-6));
        CHECK(found.evaluations < 250);
    }
}

TEST_CASE("least squares: a linear problem takes one step, whatever is at its bound")
{
    SEEDED(random, "least squares: a linear problem*");
    const MatrixXd a = MatrixXd::NullaryExpr(60, 6, [&] { return seeded::uniform(random, -1.0, 1.0); });
    const VectorXd truth = (VectorXd(6) << 0.3, 3.0, -0.2, 0.9, -4.0, 0.1).finished();
    berth::least_squares_problem task = boxed(6, -1.0, 1.0);
    task.residual = [&](const VectorXd &x, VectorXd &r) { r = a * (x - truth); };
    const auto found = berth::solve_least_squares(task, VectorXd::Zero(6));
    const MatrixXd h = a.transpose() * a;
    const VectorXd expected =
        best_of_all_places(h, -h * truth, VectorXd::Constant(6, -1.0), VectorXd::Constant(6, 1.0));
    CHECK((found.x - expected).norm() < 1e-5);
    CHECK(found.evaluations <= 1 + 6 + 2 * (1 + 6) + 1);
    CHECK((found.jacobian - a).norm() < 1e-6 * a.norm());
}

TEST_CASE("least squares: wrong slopes to begin with cost evaluations, not the answer")
{
    berth::least_squares_problem task = boxed(2, -3.0, 3.0);
    task.residual = [](const VectorXd &x, VectorXd &r) {
        r.resize(3);
        r << std::exp(0.5 * x(0)) - 2.0, x(1) + 0.2 * x(0) * x(0) - 1.0, 0.1 * x(1);
    };
    const VectorXd start = VectorXd::Zero(2);
    const auto expected = berth::solve_least_squares(task, start);
    task.slopes = MatrixXd::Zero(3, 2);
    task.slopes(0, 0) = 1.7;
    task.slopes(1, 1) = 0.6;
    task.slope_is_known = {true, false};
    const auto found = berth::solve_least_squares(task, start);
    CHECK((found.x - expected.x).norm() < 1e-5);
    CHECK(found.sum == doctest::Approx(expected.sum).epsilon(1e-9));
}

TEST_CASE("least squares: a frequency is found though a difference turns it round by more than once")
{
    /* sin(2 pi f t + phi) over 20 s, told with an error of a thousandth of a hertz; a step of 0.08 Hz turns the last
     * sample by ten radians. */
    constexpr Eigen::Index rows = 2000;
    const auto wave = [&](double f_Hz, double phase_rad) {
        VectorXd made(rows);
        for (Eigen::Index n = 0; n < rows; n++) {
            made(n) = std::sin(berth::two_pi * f_Hz * 0.01 * static_cast<double>(n) + phase_rad);
        }
        return made;
    };
    const VectorXd measured = wave(7.3, 0.4);
    berth::least_squares_problem task;
    task.residual = [&](const VectorXd &x, VectorXd &out) { out = 20.0 * (wave(x(0), x(1)) - measured); };
    task.low = VectorXd::Zero(2);
    task.high = VectorXd::Constant(2, 10.0);
    task.step = (VectorXd(2) << 0.08, 1e-3).finished();
    task.change_max = 0.3 * std::sqrt(static_cast<double>(rows));
    const auto found = berth::solve_least_squares(task, (VectorXd(2) << 7.301, 0.3).finished());
    CHECK(std::abs(found.x(0) - 7.3) < 1e-6);
    CHECK(std::abs(found.x(1) - 0.4) < 1e-5);
}

TEST_CASE("least squares: differences are asked for beside the point that was evaluated last, and nowhere else")
{
    berth::least_squares_problem task = boxed(2, 0.0, 4.0);
    VectorXd last;
    int beside = 0;
    bool is_beside = true;
    const auto value = [](const VectorXd &x) { /* Rosenbrock's valley */
                                               return VectorXd{{10.0 * (x(1) - x(0) * x(0)), 1.0 - x(0)}};
    };
    task.residual = [&](const VectorXd &x, VectorXd &out) {
        last = x;
        out = value(x);
    };
    task.residual_beside = [&](const VectorXd &x, VectorXd &out) {
        is_beside = is_beside && (x - last).norm() < 1e-5;
        beside++;
        out = value(x);
    };
    const berth::least_squares_result found = berth::solve_least_squares(task, VectorXd{{3.0, 0.5}});
    CHECK(beside > 2);
    CHECK(is_beside);
    CHECK((found.x - VectorXd{{1.0, 1.0}}).norm() < 1e-6);
}
