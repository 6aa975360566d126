#include "critical_zero.h"

#include <cmath>
#include <vector>

namespace berth
{

std::complex<double> zero_near(const loop_equation &equation, std::complex<double> w)
{
    for (int i = 0; i < 8; i++) {
        const equation_value f = evaluate(equation, w);
        w -= f.value / f.slope;
    }
    return w;
}

std::complex<double> zero_next_to_unit_circle(const loop_equation &equation)
{
    constexpr double pi = 3.14159265358979323846;
    /* Steps finer than zeros can be close in a ring, and shrinking ones towards w = 1, where slow modes lie. */
    const double step = 0.25 / (equation.degree() + 1.0);
    const auto newton_step = [&](double angle) {
        const equation_value f = evaluate(equation, std::polar(1.0, angle));
        return std::abs(f.value / f.slope);
    };
    std::vector<double> angles;
    for (double angle = 1e-6; angle < step; angle *= 1.1) {
        angles.push_back(angle);
    }
    for (double angle = step; angle < pi; angle += step) {
        angles.push_back(angle);
    }
    angles.push_back(pi);
    std::vector<double> distances;
    for (const double angle : angles) {
        distances.push_back(newton_step(angle));
    }
    std::complex<double> nearest = 0.0;
    for (std::size_t i = 0; i < angles.size(); i++) {
        const bool falls = i == 0 || distances[i] <= distances[i - 1];
        const bool rises = i + 1 == angles.size() || distances[i] <= distances[i + 1];
        if (falls && rises) {
            const std::complex<double> w = zero_near(equation, std::polar(1.0, angles[i]));
            if (std::abs(std::abs(w) - 1.0) < std::abs(std::abs(nearest) - 1.0)) {
                nearest = w;
            }
        }
    }
    return nearest;
}

} // namespace berth
