#include "spectrum.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <Eigen/Core>
#include <string>

#include "../../firmware/compensation/compensation.h"
#include "../../firmware/pi.h"
#include "../../hal/rig/beam.h"
#include "../../hal/rig/rig_file.h"
#include "../solver/balance.h"
#include "../solver/decompositions.h"
#include "../solver/power_iteration.h"
#include "arm_loop.h"
#include "critical_zero.h"
#include "dominant_root.h"
#include "first_order_limit.h"
#include "period_map.h"

namespace berth
{

namespace
{

/* All eigenvalues at once: this many take half a minute, and cost goes with the third power. One alone is found in
 * far less, but maps and limits ask for thousands. */
constexpr Eigen::Index states_max = 2048;

/* Dead time alone turns the loop over at half a period of a mode: up to here it is what swings without dead time. */
constexpr double slow_mode_periods = 1.0 / 3.0;

bool comes_first(const mode &a, const mode &b)
{
    const double larger_a = std::abs(a.z);
    const double larger_b = std::abs(b.z);
    return larger_a != larger_b ? larger_a > larger_b : a.z.imag() > b.z.imag();
}

spectrum make_spectrum(const std::vector<std::complex<double>> &eigenvalues, double period_s)
{
    spectrum result{};
    for (const auto z : eigenvalues) {
        result.modes.push_back(mode_of(z, period_s));
    }
    if (result.modes.empty()) { /* a free arm that nothing holds */
        return {{}, 1.0, 0.0, false};
    }
    std::sort(result.modes.begin(), result.modes.end(), comes_first);
    result.spectral_radius = std::abs(result.modes.front().z);
    result.growth_per_s = std::log(result.spectral_radius) / period_s;
    result.is_stable = result.spectral_radius < 1.0;
    return result;
}

/* mass s^2 + damping s + stiffness = 0, sampled. */
spectrum oscillator_spectrum(double mass, double damping, double stiffness, double period_s)
{
    const std::complex<double> root = std::sqrt(std::complex<double>(damping * damping - 4.0 * mass * stiffness));
    return make_spectrum({std::exp((-damping + root) / (2.0 * mass) * period_s),
                          std::exp((-damping - root) / (2.0 * mass) * period_s)},
                         period_s);
}

Eigen::MatrixXd balanced_map(const rig &rig)
{
    const period_map map(rig);
    refuse_too_many_states(map.layout().count);
    Eigen::MatrixXd matrix = map.matrix();
    balance(matrix);
    return matrix;
}

Eigen::VectorXcd eigenvalues_of(const rig &rig)
{
    return eigenvalues(balanced_map(rig));
}

/* All at once leave rounding: of 2000 eigenvalues 2e-10, which at 100 kHz is the fifth digit of the growth. The
 * characteristic equation knows each one better, but for those that crowd around 0. */
void refine(Eigen::VectorXcd &eigenvalues, const loop_equation &equation)
{
    constexpr double rounding = 1e-8;
    constexpr double crowded = 0.5;
    for (std::complex<double> &z : eigenvalues) {
        if (std::abs(z) > crowded) {
            const std::complex<double> w = zero_near(equation, 1.0 / z);
            z = std::abs(w * z - 1.0) < rounding ? 1.0 / w : z;
        }
    }
}

} // namespace

void refuse_too_many_states(std::int64_t count)
{
    if (count > states_max) {
        throw input_error("the loop has " + std::to_string(count) + " eigenvalues; more than " +
                          std::to_string(states_max) +
                          " take minutes: lower loop.rate_Hz, robot.dead_time_ms or sensor.delay_ms");
    }
}

mode mode_of(std::complex<double> z, double period_s)
{
    const std::complex<double> s = std::log(z) / period_s;
    const double magnitude = std::abs(s);
    return {z, s.real(), std::abs(s.imag()) / two_pi, magnitude > 0.0 ? -s.real() / magnitude : 0.0};
}

std::string mode_name(const mode &mode, const rig &rig)
{
    const double half_rate_Hz = 0.5 / config_period_s(&rig.firmware);
    const double periods = mode.frequency_Hz * loop_delay_s(rig);
    if (mode.frequency_Hz == 0.0) {
        return "drift without oscillation";
    }
    if (mode.frequency_Hz >= half_rate_Hz * (1.0 - 1e-9)) {
        return "fast mode: alternates from tick to tick";
    }
    if (periods < slow_mode_periods) {
        return "slow mode: manipulator and object together";
    }
    char text[80];
    std::snprintf(text, sizeof text, "dead-time mode: %.2f periods of it fit into the loop's delay", periods);
    return text;
}

bool drifts_freely(const rig &rig)
{
    return rig.firmware.arm.kind == ARM_NONE && rig.firmware.manipulator.stiffness_N_per_m == 0.0 &&
           (rig.object.stiffness_N_per_m == 0.0 || touches_nothing(rig));
}

spectrum loop_spectrum(const rig &rig)
{
    if (rig.firmware.arm.kind != ARM_NONE) {
        return make_spectrum(arm_loop_eigenvalues(rig), config_period_s(&rig.firmware));
    }
    Eigen::VectorXcd eigenvalues = eigenvalues_of(rig);
    if (!compensation_is_on(&rig.firmware)) {
        refine(eigenvalues, make_loop_equation(rig));
    }
    return make_spectrum({eigenvalues.begin(), eigenvalues.end()}, config_period_s(&rig.firmware));
}

double spectral_radius_of(const rig &rig)
{
    if (rig.firmware.arm.kind != ARM_NONE) {
        return loop_spectrum(rig).spectral_radius;
    }
    if (compensation_is_on(&rig.firmware)) { /* which the characteristic equation does not know */
        return eigenvalues_of(rig).cwiseAbs().maxCoeff();
    }
    refuse_too_many_states(period_map(rig).layout().count);
    return dominant_root_finder().spectral_radius(make_loop_equation(rig));
}

double guessed_spectral_radius(const rig &rig)
{
    constexpr Eigen::Index cheap_states = 60; /* all eigenvalues of this many are as fast */
    if (rig.firmware.arm.kind != ARM_NONE || !compensation_is_on(&rig.firmware)) {
        return spectral_radius_of(rig);
    }
    const Eigen::MatrixXd map = balanced_map(rig);
    return map.rows() <= cheap_states ? eigenvalues(map).cwiseAbs().maxCoeff() : power_radius(map);
}

spectrum manipulator_spectrum(const rig &rig)
{
    if (rig.firmware.arm.kind != ARM_NONE) {
        return make_spectrum(arm_eigenvalues(rig), config_period_s(&rig.firmware));
    }
    const manipulator_config &m = rig.firmware.manipulator;
    return oscillator_spectrum(m.mass_kg, m.damping_N_s_per_m, m.stiffness_N_per_m, config_period_s(&rig.firmware));
}

spectrum coupled_spectrum(const rig &rig)
{
    if (rig.firmware.arm.kind != ARM_NONE) {
        return make_spectrum(arm_with_object_eigenvalues(rig), config_period_s(&rig.firmware));
    }
    const manipulator_config &m = rig.firmware.manipulator;
    const object_rig &o = rig.object;
    const double period_s = config_period_s(&rig.firmware);
    if (o.further_mode_count > 0) {
        const linear_arm both = with_object(arm_of(m), Eigen::RowVectorXd::Ones(1), object_modes(o));
        std::vector<std::complex<double>> eigenvalues;
        for (const std::complex<double> &s : eigenvalues_of(both)) {
            eigenvalues.push_back(std::exp(s * period_s));
            if (s.imag() > 0.0) {
                eigenvalues.push_back(std::exp(std::conj(s) * period_s));
            }
        }
        return make_spectrum(eigenvalues, period_s);
    }
    return oscillator_spectrum(m.mass_kg + o.mass_kg, m.damping_N_s_per_m + o.damping_N_s_per_m,
                               m.stiffness_N_per_m + o.stiffness_N_per_m, period_s);
}

map_point map_point_of(const rig &rig)
{
    const manipulator_config &m = rig.firmware.manipulator;
    const double mass = m.mass_kg + rig.object.mass_kg;
    const double stiffness = m.stiffness_N_per_m + rig.object.stiffness_N_per_m;
    const double damping = m.damping_N_s_per_m + rig.object.damping_N_s_per_m;
    return {std::sqrt(stiffness / mass / (m.stiffness_N_per_m / m.mass_kg)),
            damping / (2.0 * std::sqrt(stiffness * mass))};
}

} // namespace berth
