#include "inverse_filter.h"

#include "matrix_exponential.h"
#include "pi.h"

namespace
{

constexpr double butterworth_damping_ratio = 0.70710678118654752;

/* Denominator z^2 + c[0] z + c[1] whose roots are exp(s T) of the roots of s^2 + 2 z w s + w^2: trace and
 * determinant of the exponential of the companion matrix. */
void matched_polynomial(double frequency_Hz, double damping_ratio, double period_s, double c[2])
{
    const double w = 2.0 * berth::pi * frequency_Hz;
    Eigen::Matrix2d a;
    a << 0.0, 1.0, -w * w, -2.0 * damping_ratio * w;
    const Eigen::Matrix2d e = berth::matrix_exponential<2>(a * period_s);
    c[0] = -(e(0, 0) + e(1, 1));
    c[1] = e(0, 0) * e(1, 1) - e(0, 1) * e(1, 0);
}

} // namespace

extern "C" {

void inverse_filter_start(inverse_filter *filter, const app_config *config)
{
    *filter = {};
    const inverse_filter_config &c = config->inverse_filter;
    filter->enabled = c.enabled;
    inverse_filter_rest_at(filter, config->manipulator.initial_position_m);
    if (!c.enabled) {
        return;
    }
    const double period_s = config_period_s(config);
    double zeros[2];
    matched_polynomial(c.robot_frequency_Hz, c.robot_damping_ratio, period_s, zeros);
    matched_polynomial(c.bandwidth_Hz, butterworth_damping_ratio, period_s, filter->a);
    const double gain = (1.0 + filter->a[0] + filter->a[1]) / (1.0 + zeros[0] + zeros[1]);
    filter->b[0] = gain;
    filter->b[1] = gain * zeros[0];
    filter->b[2] = gain * zeros[1];
}

double inverse_filter_delay_s(const app_config *config)
{
    inverse_filter f;
    inverse_filter_start(&f, config);
    if (!f.enabled) {
        return 0.0;
    }
    return config_period_s(config) * ((f.b[1] + 2.0 * f.b[2]) / (f.b[0] + f.b[1] + f.b[2]) -
                                      (f.a[0] + 2.0 * f.a[1]) / (1.0 + f.a[0] + f.a[1]));
}

void inverse_filter_rest_at(inverse_filter *filter, double position_m)
{
    filter->input_m[0] = filter->input_m[1] = position_m;
    filter->output_m[0] = filter->output_m[1] = position_m;
}

double inverse_filter_step(inverse_filter *filter, double wanted_m)
{
    if (!filter->enabled) {
        return wanted_m;
    }
    const double output_m = filter->b[0] * wanted_m + filter->b[1] * filter->input_m[0] +
                            filter->b[2] * filter->input_m[1] - filter->a[0] * filter->output_m[0] -
                            filter->a[1] * filter->output_m[1];
    filter->input_m[1] = filter->input_m[0];
    filter->input_m[0] = wanted_m;
    filter->output_m[1] = filter->output_m[0];
    filter->output_m[0] = output_m;
    return output_m;
}
}
