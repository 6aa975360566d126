#include "loop_equation.h"

#include <algorithm>
#include <cmath>

#include "../../firmware/inverse_filter.h"
#include "../../firmware/manipulator.h"
#include "arm_loop.h"
#include "compensation_states.h"
#include "hardware_period.h"
#include "slow_response.h"

namespace berth
{

namespace
{

short_factor multiplied_out(const slow_factor &f)
{
    return {f.c0 + f.c1 + f.c2, -f.c1 - 2.0 * f.c2, f.c2, f.c2 == 0.0 ? 1 : 2};
}

/* det(1 - w (1 + n)) of a change n over one period. */
slow_factor poles_of(const two_by_two &n)
{
    const double determinant = n.determinant();
    return {determinant, -n.trace() - 2.0 * determinant, 1.0 + n.trace() + determinant};
}

/* 1 - w (1 + n) */
slow_factor pole_of(double n)
{
    return {-n, 1.0 + n, 0.0};
}

slow_factor slow_factor_of(const std::array<double, 3> &c)
{
    return {c[0] + c[1] + c[2], -c[1] - 2.0 * c[2], c[2]};
}

bool is_same(const loop_config &a, const loop_config &b)
{
    return a.rate_Hz == b.rate_Hz;
}

bool is_same(const manipulator_config &a, const manipulator_config &b)
{
    return a.mass_kg == b.mass_kg && a.damping_N_s_per_m == b.damping_N_s_per_m &&
           a.stiffness_N_per_m == b.stiffness_N_per_m && a.integrator == b.integrator && a.substeps == b.substeps;
}

bool is_same(const inverse_filter_config &a, const inverse_filter_config &b)
{
    return a.enabled == b.enabled && a.robot_frequency_Hz == b.robot_frequency_Hz &&
           a.robot_damping_ratio == b.robot_damping_ratio && a.bandwidth_Hz == b.bandwidth_Hz;
}

/* Multiplied out, less than this share of B is left at w = 1. */
constexpr double slow_share = 1e-7;

/* |z - 1|^2 within which B is taken by powers of z - 1, where it is known by those. */
constexpr double slow_norm = 0.5;

bool cancels_near_one(const short_polynomial &p)
{
    double sum = 0.0;
    double sum_of_magnitudes = 0.0;
    for (const double c : p.coefficients) {
        sum += c;
        sum_of_magnitudes += std::abs(c);
    }
    return std::abs(sum) < slow_share * sum_of_magnitudes;
}

/* Setpoint to sample, w^(whole dead periods - 1) left out: zeros = poles * (samples after a single setpoint of 1 m),
 * which ends after as many terms as there are poles and setpoints in a period. */
short_polynomial hardware_zeros(const hardware_period &hardware, const short_factor *poles)
{
    short_polynomial zeros;
    zeros.degree = hardware.state_count() + 2;
    beam_state state = beam_state::Zero();
    for (int n = 0; n <= zeros.degree; n++) {
        zeros.coefficients[static_cast<std::size_t>(n)] =
            hardware.advance(state, {n == 0 ? 1.0 : 0.0, n == 1 ? 1.0 : 0.0, n == 2 ? 1.0 : 0.0});
    }
    for (int i = 0; i < hardware.link_count(); i++) {
        multiply(zeros.coefficients.data(), zeros.degree + 1, poles[i]);
    }
    return zeros;
}

} // namespace

std::complex<double> power(std::complex<double> w, int n)
{
    std::complex<double> result = 1.0;
    for (std::complex<double> square = w; n > 0; n >>= 1, square *= square) {
        result = n & 1 ? result * square : result;
    }
    return result;
}

namespace
{

/* Horner */
equation_value of_polynomial(const short_polynomial &p, std::complex<double> w)
{
    equation_value b{p.coefficients[static_cast<std::size_t>(p.degree)], 0.0};
    for (int i = p.degree - 1; i >= 0; i--) {
        b.slope = b.slope * w + b.value;
        b.value = b.value * w + p.coefficients[static_cast<std::size_t>(i)];
    }
    return b;
}

/* w^degree q(1/w - 1) */
equation_value of_slow(const short_polynomial &q, std::complex<double> w)
{
    const equation_value at = of_polynomial(q, (1.0 - w) / w);
    const std::complex<double> before_that = power(w, q.degree - 2);
    return {before_that * w * w * at.value, before_that * (static_cast<double>(q.degree) * w * at.value - at.slope)};
}

} // namespace

equation_parts evaluate_parts(const loop_equation &equation, std::complex<double> w)
{
    const std::complex<double> e = 1.0 - w;
    const auto of_factor = [&](const slow_factor &f) {
        return equation_value{f.c0 + e * (f.c1 + e * f.c2), -f.c1 - 2.0 * f.c2 * e};
    };
    const auto product = [](const equation_value &p, const equation_value &q) {
        return equation_value{p.value * q.value, p.slope * q.value + p.value * q.slope};
    };
    equation_value a = of_factor(equation.a_factors[0]);
    for (int i = 1; i < equation.a_factor_count; i++) {
        a = product(a, of_factor(equation.a_factors[static_cast<std::size_t>(i)]));
    }
    const bool is_slow = equation.has_b_slow && std::norm(e) < slow_norm * std::norm(w);
    const equation_value rest = is_slow ? of_slow(equation.b_slow, w) : of_polynomial(equation.b_rest, w);
    const equation_value b = product(rest, of_factor(equation.b_factor));
    return {a.value, a.slope, b.value, b.slope};
}

equation_value evaluate(const loop_equation &equation, std::complex<double> w)
{
    const equation_parts parts = evaluate_parts(equation, w);
    if (equation.delay == 0) {
        return {parts.a + parts.b, parts.a_slope + parts.b_slope};
    }
    const std::complex<double> before = power(w, equation.delay - 1);
    const std::complex<double> delayed = before * w;
    return {parts.a + delayed * parts.b,
            parts.a_slope + delayed * parts.b_slope + static_cast<double>(equation.delay) * before * parts.b};
}

bool is_finite(const loop_equation &equation)
{
    /* On the circle as well: what overflows need not do so everywhere. */
    for (const std::complex<double> w : {std::complex<double>(0.5), std::polar(1.0, 0.01), std::polar(1.0, 1.0)}) {
        const equation_value f = evaluate(equation, w);
        if (!std::isfinite(f.value.real()) || !std::isfinite(f.value.imag()) || !std::isfinite(f.slope.real())) {
            return false;
        }
    }
    return true;
}

std::array<std::complex<double>, 2> roots_of(const slow_factor &f)
{
    if (f.c2 == 0.0) {
        return {1.0 + f.c0 / f.c1, unlimited};
    }
    const std::complex<double> root = std::sqrt(std::complex<double>(f.c1 * f.c1 - 4.0 * f.c2 * f.c0));
    const std::complex<double> q = -0.5 * (f.c1 + (f.c1 < 0.0 ? -root : root));
    return {1.0 - q / f.c2, q == 0.0 ? 1.0 : 1.0 - f.c0 / q};
}

loop_equation_maker::firmware_response loop_equation_maker::respond(const app_config &config)
{
    manipulator m;
    manipulator_start(&m, &config);
    const operator_command rest{};
    const auto step = [&](double position_m, double velocity_m_per_s, double force_N) {
        m.position_m = position_m;
        m.velocity_m_per_s = velocity_m_per_s;
        manipulator_step(&m, &rest, force_N);
        return pair_vector{m.position_m, m.velocity_m_per_s};
    };
    const pair_vector x = step(1.0, 0.0, 0.0);
    const pair_vector v = step(0.0, 1.0, 0.0);
    const pair_vector push = step(0.0, 0.0, -1.0);
    firmware_response made;
    made.zeros = {push[0], v[0] * push[1] - v[1] * push[0]};
    made.poles = poles_of(two_by_two{{x - pair_vector{1.0, 0.0}, v - pair_vector{0.0, 1.0}}});

    inverse_filter filter;
    inverse_filter_start(&filter, &config);
    made.has_filter = filter.enabled != 0;
    made.filter_zeros = {filter.b[0], filter.b[1], filter.b[2]};
    made.filter_poles = {1.0, filter.a[0], filter.a[1]};
    return made;
}

loop_equation loop_equation_maker::make(const rig &rig)
{
    const app_config &firmware = rig.firmware;
    refuse_compensation(rig);
    refuse_arm(rig);
    if (!has_response_ || !is_same(firmware.loop, loop_) || !is_same(firmware.manipulator, manipulator_) ||
        !is_same(firmware.inverse_filter, filter_)) {
        response_ = respond(firmware);
        loop_ = firmware.loop;
        manipulator_ = firmware.manipulator;
        filter_ = firmware.inverse_filter;
        has_response_ = true;
    }
    const hardware_period hardware(rig);

    /* 1 + w^(sample age) w^(dead periods - 1) w (manipulator filter hardware) = 0 */
    loop_equation made;
    made.delay = hardware.sample_age_ticks() + hardware.whole_dead_periods();
    const auto add_poles = [&](const slow_factor &poles) {
        made.a_factors[static_cast<std::size_t>(made.a_factor_count++)] = poles;
    };
    made.a.coefficients[0] = 1.0;
    std::array<short_factor, hardware_chain::links_max> poles{};
    for (int i = 0; i < hardware.link_count(); i++) {
        const two_by_two change = hardware.link_change(i);
        add_poles(hardware.link_has_two_states(i) ? poles_of(change) : pole_of(change(0, 0)));
        poles[static_cast<std::size_t>(i)] = multiplied_out(made.a_factors[static_cast<std::size_t>(i)]);
        multiply(made.a, poles[static_cast<std::size_t>(i)]);
    }
    made.b_rest = hardware_zeros(hardware, poles.data());
    multiply(made.b_rest, {response_.zeros[0], response_.zeros[1], 0.0, 1});
    made.has_b_slow = cancels_near_one(made.b_rest);
    if (made.has_b_slow) { /* zeros[0] + zeros[1] w = w (zeros[0] / w + zeros[1]) */
        made.b_slow = slow_response(hardware);
        multiply(made.b_slow, {response_.zeros[0] + response_.zeros[1], response_.zeros[0], 0.0, 1});
    }
    made.b = made.b_rest;
    add_poles(response_.poles);
    multiply(made.a, multiplied_out(response_.poles));
    if (response_.has_filter) {
        const auto &[b0, b1, b2] = response_.filter_zeros;
        const auto &[a0, a1, a2] = response_.filter_poles;
        made.b_factor = slow_factor_of(response_.filter_zeros);
        add_poles(slow_factor_of(response_.filter_poles));
        multiply(made.b, {b0, b1, b2, 2});
        multiply(made.a, {a0, a1, a2, 2});
    }
    return made;
}

loop_equation make_loop_equation(const rig &rig)
{
    return loop_equation_maker().make(rig);
}

} // namespace berth
