#include "loop_equation.h"

#include <algorithm>
#include <Eigen/Core>
#include <Eigen/LU>

#include "../../firmware/inverse_filter.h"
#include "../../firmware/manipulator.h"
#include "hardware_period.h"

namespace berth
{

namespace
{

short_polynomial polynomial(std::initializer_list<double> coefficients)
{
    short_polynomial p;
    std::copy(coefficients.begin(), coefficients.end(), p.coefficients.begin());
    p.degree = static_cast<int>(coefficients.size()) - 1;
    return p;
}

short_polynomial operator*(const short_polynomial &p, const short_polynomial &q)
{
    short_polynomial r;
    r.degree = p.degree + q.degree;
    for (int i = 0; i <= p.degree; i++) {
        for (int j = 0; j <= q.degree; j++) {
            r.coefficients[static_cast<std::size_t>(i + j)] +=
                p.coefficients[static_cast<std::size_t>(i)] * q.coefficients[static_cast<std::size_t>(j)];
        }
    }
    return r;
}

/* det(1 - w m). */
short_polynomial poles_of(const Eigen::Matrix2d &m)
{
    return polynomial({1.0, -m.trace(), m.determinant()});
}

/* Zeros and poles of a block, by powers of w. */
struct response {
    short_polynomial zeros;
    short_polynomial poles;
};

/* -F to x, without the one w that every step takes. */
response manipulator_response(const app_config &config)
{
    manipulator m;
    manipulator_start(&m, &config);
    const operator_command rest{};
    const auto step = [&](double position_m, double velocity_m_per_s, double force_N) {
        m.position_m = position_m;
        m.velocity_m_per_s = velocity_m_per_s;
        manipulator_step(&m, &rest, force_N);
        return Eigen::Vector2d(m.position_m, m.velocity_m_per_s);
    };
    Eigen::Matrix2d transition;
    transition << step(1.0, 0.0, 0.0), step(0.0, 1.0, 0.0);
    const Eigen::Vector2d push = step(0.0, 0.0, -1.0);
    return {polynomial({push(0), transition(0, 1) * push(1) - transition(1, 1) * push(0)}), poles_of(transition)};
}

response filter_response(const app_config &config)
{
    inverse_filter f;
    inverse_filter_start(&f, &config);
    if (!f.enabled) {
        return {polynomial({1.0}), polynomial({1.0})};
    }
    return {polynomial({f.b[0], f.b[1], f.b[2]}), polynomial({1.0, f.a[0], f.a[1]})};
}

/* States come in pairs (a first-order low-pass: alone), each driven by the ones before it: the transition is block
 * triangular and its diagonal blocks have the poles. */
short_polynomial hardware_poles(const hardware_period &hardware)
{
    const auto transition = hardware.transition();
    short_polynomial poles = polynomial({1.0});
    for (int i = 0; i < hardware.state_count(); i += 2) {
        const int first = hardware.state(i);
        if (i + 1 == hardware.state_count()) {
            return poles * polynomial({1.0, -transition(first, first)});
        }
        poles = poles * poles_of(transition.block<2, 2>(first, first));
    }
    return poles;
}

/* Setpoint to sample, w^(whole dead periods - 1) left out: zeros = poles * (samples after a single setpoint of 1 m),
 * which ends after as many terms as there are poles and setpoints in a period. */
response hardware_response(const hardware_period &hardware)
{
    response result{{}, hardware_poles(hardware)};
    result.zeros.degree = hardware.state_count() + 2;
    std::array<double, short_polynomial::capacity> samples{};
    plant_state state = plant_state::Zero();
    for (int n = 0; n <= result.zeros.degree; n++) {
        samples[static_cast<std::size_t>(n)] =
            hardware.advance(state, {n == 0 ? 1.0 : 0.0, n == 1 ? 1.0 : 0.0, n == 2 ? 1.0 : 0.0});
        for (int i = 0; i <= std::min(n, result.poles.degree); i++) {
            result.zeros.coefficients[static_cast<std::size_t>(n)] +=
                result.poles.coefficients[static_cast<std::size_t>(i)] * samples[static_cast<std::size_t>(n - i)];
        }
    }
    return result;
}

} // namespace

int loop_equation::degree() const
{
    return std::max(a.degree, delay + b.degree);
}

equation_value evaluate(const loop_equation &equation, std::complex<double> w)
{
    const auto horner = [&](const short_polynomial &p) {
        equation_value v{p.coefficients[static_cast<std::size_t>(p.degree)], 0.0};
        for (int i = p.degree - 1; i >= 0; i--) {
            v.slope = v.slope * w + v.value;
            v.value = v.value * w + p.coefficients[static_cast<std::size_t>(i)];
        }
        return v;
    };
    const equation_value a = horner(equation.a);
    const equation_value b = horner(equation.b);
    std::complex<double> power = 1.0; /* w^delay, by squaring */
    std::complex<double> square = w;
    for (int n = equation.delay; n > 0; n >>= 1) {
        power = n & 1 ? power * square : power;
        square *= square;
    }
    return {a.value + power * b.value,
            a.slope + power * (b.slope + static_cast<double>(equation.delay) / w * b.value)};
}

loop_equation make_loop_equation(const rig &rig)
{
    const hardware_period hardware(rig);
    const response arm = manipulator_response(rig.firmware);
    const response filter = filter_response(rig.firmware);
    const response rest = hardware_response(hardware);
    /* 1 + w^(sample age) w^(dead periods - 1) w (arm filter hardware) = 0 */
    return {arm.poles * filter.poles * rest.poles, arm.zeros * filter.zeros * rest.zeros,
            hardware.sample_age_ticks() + hardware.whole_dead_periods()};
}

} // namespace berth
