#include "adaptive_inverse.h"

#include <algorithm>

#include "../matrix_exponential.h"
#include "../pi.h"

namespace
{

constexpr double learnt_tolerances_max = 3.0;

/* Positions are compared about their mean over so many times the band's own time: where zero lies says nothing. */
constexpr double slow_part = 0.01;

double share_of(double rate_per_s, double period_s)
{
    Eigen::Matrix<double, 1, 1> decay;
    decay << -rate_per_s * period_s;
    return 1.0 - berth::matrix_exponential<1>(decay)(0, 0);
}

/* 1 / (1 + s/w)^n, n: terms. States: the output and its derivatives over w^i; the input is held over a tick. */
void set_band(adaptive_inverse &inverse)
{
    constexpr int states = INVERSE_TERMS_MAX;
    const inverse_settings &s = inverse.settings;
    const double w = berth::two_pi * s.bandwidth_Hz;
    const auto n = static_cast<int>(s.terms);
    using matrix = Eigen::Matrix<double, states + 1, states + 1>;
    matrix a = matrix::Zero();
    double binomial = 1.0;
    for (int i = 0; i < n; i++) {
        a(n - 1, i) = -binomial;
        binomial *= static_cast<double>(n - i) / static_cast<double>(i + 1);
        if (i + 1 < n) {
            a(i, i + 1) = 1.0;
        }
    }
    a(n - 1, states) = 1.0;
    const matrix over = berth::matrix_exponential<states + 1>(a * (w * s.period_s));
    Eigen::Map<Eigen::Matrix<double, states, states + 1, Eigen::RowMajor>>(&inverse.transition[0][0]) =
        over.topRows<states>();
    inverse.slow_share = share_of(slow_part * w, s.period_s);
    double unit = 1.0;
    double gains_squared = 0.0; /* of the noise in each term, at most */
    for (int i = 0; i < states; i++) {
        inverse.unit_per_s[i] = unit;
        gains_squared += s.told[i] * unit * s.told[i] * unit;
        unit *= w;
    }
    inverse.noise_squared = s.position_noise_m * s.position_noise_m * gains_squared;
}

/* As if both had always been there. */
void open_bands(adaptive_inverse &inverse, double setpoint_m, double reported_m)
{
    inverse.commanded = inverse.reported = {};
    inverse.commanded.slow_m = setpoint_m;
    inverse.reported.slow_m = reported_m;
    past_fill(&inverse.setpoint_m, setpoint_m);
    inverse.is_open = 1;
}

void filter(const adaptive_inverse &inverse, inverse_band &band, double position_m)
{
    const double input_m = position_m - band.slow_m;
    band.slow_m += inverse.slow_share * input_m;
    double next[INVERSE_TERMS_MAX];
    for (uint32_t i = 0; i < inverse.settings.terms; i++) {
        next[i] = inverse.transition[i][INVERSE_TERMS_MAX] * input_m;
        for (uint32_t j = 0; j < inverse.settings.terms; j++) {
            next[i] += inverse.transition[i][j] * band.derivative_m[j];
        }
    }
    std::copy_n(next, inverse.settings.terms, band.derivative_m);
}

/* The loop's rig has three terms: a robot's derivatives beyond the second are all noise. */
constexpr uint32_t rig_terms = 3;

/* a (1 + b s + c s^2), as far as the series goes. */
void multiply(double *a, double b, double c)
{
    a[2] += b * a[1] + c * a[0];
    a[1] += b * a[0];
}

void correct(adaptive_inverse &inverse)
{
    const inverse_settings &s = inverse.settings;
    double tells[INVERSE_TERMS_MAX]; /* what a share of 1 of each would change, m */
    double spread[INVERSE_TERMS_MAX];
    double visible = 0.0;
    double variance = inverse.noise_squared;
    inverse.error_m = inverse.commanded.derivative_m[0];
    for (uint32_t i = 0; i < s.terms; i++) {
        const double derivative = inverse.reported.derivative_m[i] * inverse.unit_per_s[i];
        inverse.error_m -= inverse.coefficient[i] * derivative;
        tells[i] = s.tolerance[i] * derivative;
        visible += tells[i] * tells[i];
    }
    for (uint32_t i = 0; i < s.terms; i++) {
        spread[i] = 0.0;
        for (uint32_t j = 0; j < s.terms; j++) {
            spread[i] += inverse.covariance[i][j] * tells[j];
        }
        variance += tells[i] * spread[i];
    }
    const double forgotten = inverse.forgetting * visible / (visible + inverse.noise_squared);
    for (uint32_t i = 0; i < s.terms; i++) {
        inverse.share[i] = std::clamp(inverse.share[i] + spread[i] / variance * inverse.error_m,
                                      -learnt_tolerances_max, learnt_tolerances_max);
        inverse.coefficient[i] = s.told[i] + s.tolerance[i] * inverse.share[i];
        for (uint32_t j = 0; j < s.terms; j++) {
            double &entry = inverse.covariance[i][j];
            entry -= spread[i] * spread[j] / variance;
            entry += forgotten * ((i == j ? 1.0 : 0.0) - entry);
        }
    }
}

} // namespace

extern "C" {

inverse_settings inverse_settings_of(const app_config *config)
{
    const adaptive_inverse_config &c = config->adaptive_inverse;
    const hardware_model &m = config->hardware;
    inverse_settings settings{};
    settings.period_s = config_period_s(config);
    settings.terms = rig_terms;
    double *const a = settings.told;
    const double held_s = m.holds ? 0.5 * settings.period_s : 0.0;
    const double dead_s = 1e-3 * m.setpoint_to_motion_ms + held_s;
    a[0] = 1.0 / m.robot_gain;
    multiply(a, dead_s, 0.5 * dead_s * dead_s);
    if (m.robot_w_rad_per_s > 0.0) {
        multiply(a, 2.0 * m.robot_damping_ratio / m.robot_w_rad_per_s,
                 1.0 / (m.robot_w_rad_per_s * m.robot_w_rad_per_s));
    }
    multiply(a, 1e-3 * m.robot_lag_ms, 0.0);
    settings.tolerance[0] = c.gain_tolerance;
    settings.tolerance[1] = c.tolerance * a[1];
    settings.tolerance[2] = c.tolerance * a[2];
    settings.bandwidth_Hz = c.bandwidth_Hz;
    settings.report_age_ticks = 1e-3 * m.report_age_ms / settings.period_s;
    settings.position_noise_m = c.position_noise_m;
    settings.memory_s = c.memory_s;
    settings.correction_max_m = c.correction_max_m;
    return settings;
}

int adaptive_inverse_fits(const app_config *config)
{
    return inverse_settings_of(config).report_age_ticks < PAST_TICKS_BEFORE_MAX;
}

void adaptive_inverse_start(adaptive_inverse *inverse, const inverse_settings *settings, double position_m)
{
    *inverse = {};
    inverse->settings = *settings;
    inverse->forgetting = std::min(1.0, settings->period_s / settings->memory_s);
    set_band(*inverse);
    inverse->learns = std::any_of(settings->tolerance, settings->tolerance + settings->terms,
                                  [](double tolerance) { return tolerance > 0.0; });
    adaptive_inverse_rest_at(inverse, position_m);
}

void adaptive_inverse_rest_at(adaptive_inverse *inverse, double position_m)
{
    open_bands(*inverse, position_m, position_m);
    inverse->before_m[0] = inverse->before_m[1] = inverse->wanted_slow_m = position_m;
    for (uint32_t i = 0; i < INVERSE_TERMS_MAX; i++) {
        inverse->share[i] = 0.0;
        inverse->coefficient[i] = inverse->settings.told[i];
        for (uint32_t j = 0; j < INVERSE_TERMS_MAX; j++) {
            inverse->covariance[i][j] = i == j ? 1.0 : 0.0;
        }
    }
    inverse->error_m = 0.0;
}

double adaptive_inverse_step(adaptive_inverse *inverse, const double *derivatives)
{
    const inverse_settings &s = inverse->settings;
    const double motion_m = derivatives[0] - inverse->wanted_slow_m;
    inverse->wanted_slow_m += inverse->slow_share * motion_m;
    double wanted_m = s.told[0] * derivatives[0] + (inverse->coefficient[0] - s.told[0]) * motion_m;
    for (uint32_t i = 1; i < s.terms; i++) {
        wanted_m += inverse->coefficient[i] * derivatives[i];
    }
    const double correction_m = wanted_m - derivatives[0];
    if (correction_m > s.correction_max_m || correction_m < -s.correction_max_m) {
        inverse->saturated++;
        return derivatives[0] + (correction_m < 0.0 ? -s.correction_max_m : s.correction_max_m);
    }
    return wanted_m;
}

double adaptive_inverse_follow(adaptive_inverse *inverse, double position_m)
{
    const double period_s = inverse->settings.period_s;
    double *const before_m = inverse->before_m;
    const double derivatives[INVERSE_TERMS_MAX] = {
        position_m, (1.5 * position_m - 2.0 * before_m[0] + 0.5 * before_m[1]) / period_s,
        (position_m - 2.0 * before_m[0] + before_m[1]) / (period_s * period_s)};
    before_m[1] = before_m[0];
    before_m[0] = position_m;
    return adaptive_inverse_step(inverse, derivatives);
}

void adaptive_inverse_pause(adaptive_inverse *inverse)
{
    inverse->is_open = 0;
}

void adaptive_inverse_learn(adaptive_inverse *inverse, double setpoint_m, double reported_m)
{
    if (!inverse->learns) {
        return;
    }
    if (!inverse->is_open) {
        open_bands(*inverse, setpoint_m, reported_m);
    }
    past_add(&inverse->setpoint_m, setpoint_m);
    filter(*inverse, inverse->commanded, past_before(&inverse->setpoint_m, inverse->settings.report_age_ticks));
    filter(*inverse, inverse->reported, reported_m);
    correct(*inverse);
}
}
