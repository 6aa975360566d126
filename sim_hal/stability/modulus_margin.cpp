#include "modulus_margin.h"

#include <cmath>
#include <vector>

#include "../../firmware/pi.h"
#include "dominant_root.h"

namespace berth
{

namespace
{

/* |1 + L| at an angle of z on the unit circle. */
double distance_at(const loop_equation &equation, double angle)
{
    const std::complex<double> w = std::polar(1.0, -angle);
    const equation_parts parts = evaluate_parts(equation, w);
    return std::abs(1.0 + power(w, equation.delay) * parts.b / parts.a);
}

/* The least between two angles, by golden section. */
double least_between(const loop_equation &equation, double low, double high)
{
    constexpr double golden = 0.61803398874989484820;
    constexpr int rounds = 40;
    double a = high - golden * (high - low);
    double b = low + golden * (high - low);
    double at_a = distance_at(equation, a);
    double at_b = distance_at(equation, b);
    for (int i = 0; i < rounds; i++) {
        if (at_a < at_b) {
            high = b;
            b = a;
            at_b = at_a;
            a = high - golden * (high - low);
            at_a = distance_at(equation, a);
        } else {
            low = a;
            a = b;
            at_a = at_b;
            b = low + golden * (high - low);
            at_b = distance_at(equation, b);
        }
    }
    return std::min(at_a, at_b);
}

} // namespace

double modulus_margin(const loop_equation &equation)
{
    constexpr int points = 2000;
    constexpr double lowest = 1e-6; /* of half the rate */
    const auto angle = [](int i) { return pi * std::pow(lowest, 1.0 - static_cast<double>(i) / (points - 1)); };
    std::vector<double> distance;
    distance.reserve(points);
    for (int i = 0; i < points; i++) {
        distance.push_back(distance_at(equation, angle(i)));
    }
    double least = std::min(distance.front(), distance.back());
    for (std::size_t i = 1; i + 1 < distance.size(); i++) {
        if (distance[i] <= distance[i - 1] && distance[i] <= distance[i + 1]) {
            const auto at = static_cast<int>(i);
            least = std::min(least, least_between(equation, angle(at - 1), angle(at + 1)));
        }
    }
    /* A mode that hardly decays is a dip narrower than the grid. */
    dominant_root_finder finder;
    finder.spectral_radius(equation);
    const double mode = std::abs(std::arg(finder.dominant_eigenvalue()));
    const double wide = 1e-3 * mode;
    return mode > 0.0 ? std::min(least, least_between(equation, mode - wide, std::min(pi, mode + wide))) : least;
}

} // namespace berth
