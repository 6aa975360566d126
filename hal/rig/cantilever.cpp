#include "cantilever.h"

#include <cmath>
#include <string>

#include "../../firmware/pi.h"
#include "rig_file.h"

namespace berth
{

namespace
{

/* The frequency equation, divided by (1 + k) cosh b so that it stays of the size of 1. */
double frequency_equation(double b, double root)
{
    const double cosine = std::cos(b);
    const double sine = std::sin(b);
    const double clamped = 1.0 / std::cosh(b) + cosine;
    const double hinged = b * (cosine * std::tanh(b) - sine);
    return std::isinf(root) ? clamped : (root * clamped + hinged) / (1.0 + root);
}

double wave_number_of(int mode, double root)
{
    /* One root in each stretch of pi: a hinge's lie a quarter above whole multiples, a clamp's a half. */
    double low = mode * pi + (mode == 0 ? 1e-6 : 0.5);
    double high = (mode + 1) * pi;
    const bool is_rising = frequency_equation(low, root) < 0.0;
    for (int i = 0; i < 200 && high - low > 1e-15 * high; i++) {
        const double middle = 0.5 * (low + high);
        ((frequency_equation(middle, root) < 0.0) == is_rising ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

/* Square of the tip's deflection in the mode whose mean square along the beam is 1. */
double tip_square(double b, double root)
{
    /* w = a (cosh - cos) + u sinh + d sin of b x / L with a = 1, d = 2 b a / root - u. */
    const double hinge = std::isinf(root) ? 0.0 : 2.0 * b / root;
    /* 1 + u by itself: next to a growing exponential it must not be the difference of large numbers. */
    const double one_plus_u =
        (std::sin(b) * (1.0 + hinge) - std::cos(b) - std::exp(-b)) / (std::sinh(b) + std::sin(b));
    const double u = one_plus_u - 1.0;
    const double d = hinge - u;
    const auto shape = [&](double x) {
        const double growing = 0.5 * one_plus_u * std::exp(b * x);
        const double falling = 0.5 * (1.0 - u) * std::exp(-b * x);
        return growing + falling - std::cos(b * x) + d * std::sin(b * x);
    };
    /* Gauss-Legendre, 5 points in each of 64 parts: exact to rounding for modes of up to 8 half waves. */
    static const double at[] = {0.0, 0.5384693101056831, 0.9061798459386640};
    static const double weight[] = {0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
    constexpr int parts = 64;
    double square = 0.0;
    for (int part = 0; part < parts; part++) {
        const double middle = (part + 0.5) / parts;
        for (int i = 0; i < 3; i++) {
            const double left = shape(middle - 0.5 * at[i] / parts);
            const double right = shape(middle + 0.5 * at[i] / parts);
            square += 0.5 / parts * weight[i] * (i == 0 ? left * left : left * left + right * right);
        }
    }
    return shape(1.0) * shape(1.0) / square;
}

} // namespace

std::vector<beam_mode> modes_of(const cantilever &beam, int count)
{
    if (!(beam.length_m > 0.0) || !(beam.mass_kg_per_m > 0.0) || !(beam.bending_stiffness_N_m2 > 0.0) ||
        !(beam.root_N_m_per_rad > 0.0) || !(beam.damping_ratio >= 0.0)) {
        throw input_error("a beam needs length, mass, bending stiffness and a spring at its root greater than 0");
    }
    if (count < 1 || count > beam_modes_max) {
        throw input_error("a beam has from 1 to " + std::to_string(beam_modes_max) + " modes here");
    }
    const double root = beam.root_N_m_per_rad * beam.length_m / beam.bending_stiffness_N_m2;
    std::vector<beam_mode> modes;
    for (int i = 0; i < count; i++) {
        const double b = wave_number_of(i, root);
        const double per_length = b / beam.length_m;
        const double w = per_length * per_length * std::sqrt(beam.bending_stiffness_N_m2 / beam.mass_kg_per_m);
        const double mass = beam.mass_kg_per_m * beam.length_m / tip_square(b, root);
        modes.push_back({b, w / (2.0 * pi), mass, 2.0 * beam.damping_ratio * w * mass, w * w * mass});
    }
    return modes;
}

cantilever beam_for(double length_m, double frequency_Hz, double tip_mass_kg, double damping_ratio)
{
    cantilever beam = {length_m, 4.0 * tip_mass_kg / length_m, 1.0, cantilever().root_N_m_per_rad, damping_ratio};
    const double at_unit_Hz = modes_of(beam, 1).front().frequency_Hz;
    beam.bending_stiffness_N_m2 = (frequency_Hz / at_unit_Hz) * (frequency_Hz / at_unit_Hz);
    return beam;
}

} // namespace berth
