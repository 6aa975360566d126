#include "critical_zero.h"

#include <cmath>
#include <vector>

#include "../../firmware/pi.h"

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
    /* Steps finer than zeros can be close in a ring, and shrinking ones towards w = 1, where slow modes lie. */
    const int even_steps = 4 * (equation.degree() + 1) * 3 + 1;
    constexpr int shrinking_steps = 120;
    const double step = pi / even_steps;
    const auto angle_at = [&](int i) {
        return i < shrinking_steps ? step * std::pow(0.9, shrinking_steps - i) : step * (i - shrinking_steps + 1);
    };
    std::vector<double> distances(static_cast<std::size_t>(shrinking_steps + even_steps));
    for (std::size_t i = 0; i < distances.size(); i++) {
        const equation_value f = evaluate(equation, std::polar(1.0, angle_at(static_cast<int>(i))));
        distances[i] = std::abs(f.value / f.slope);
    }
    std::complex<double> nearest = 0.0;
    for (std::size_t i = 0; i < distances.size(); i++) {
        const bool falls = i == 0 || distances[i] <= distances[i - 1];
        const bool rises = i + 1 == distances.size() || distances[i] <= distances[i + 1];
        if (falls && rises) {
            const std::complex<double> w = zero_near(equation, std::polar(1.0, angle_at(static_cast<int>(i))));
            if (std::abs(std::abs(w) - 1.0) < std::abs(std::abs(nearest) - 1.0)) {
                nearest = w;
            }
        }
    }
    return nearest;
}

} // namespace berth
