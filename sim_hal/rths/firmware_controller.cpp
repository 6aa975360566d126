#include "firmware_controller.h"

#include <cmath>

namespace berth::rths
{

namespace
{

series times(const series &a, const series &b)
{
    series product = series::Zero();
    for (int i = 0; i < product.size(); i++) {
        for (int j = 0; i + j < product.size(); j++) {
            product(i + j) += a(i) * b(j);
        }
    }
    return product;
}

/* exp(s T / 2): a command is held for a sample. */
series half_a_sample()
{
    series lead = series::Zero();
    double term = 1.0;
    for (int i = 0; i < lead.size(); i++) {
        lead(i) = term;
        term *= 0.5 * period_s / static_cast<double>(i + 1);
    }
    return lead;
}

/* What one standard deviation of each uncertain property changes, in all. */
series spread_of_inverse(const transfer_parameters &nominal)
{
    series squares = series::Zero();
    for (const uncertain_property &property : uncertain_properties) {
        transfer_parameters other = nominal;
        other.*property.of += property.deviation;
        squares += (inverse_of(other) - inverse_of(nominal)).cwiseAbs2();
    }
    return squares.cwiseSqrt();
}

inverse_settings inverse_settings_for(const transfer_parameters &nominal)
{
    inverse_settings settings{};
    settings.period_s = period_s;
    settings.terms = INVERSE_TERMS_MAX;
    Eigen::Map<series>(settings.told) = times(inverse_of(nominal), half_a_sample());
    Eigen::Map<series>(settings.tolerance) = spread_of_inverse(nominal);
    settings.bandwidth_Hz = 10.0; /* of the frame's motion: its first three modes count, the first most */
    settings.position_noise_m = position_noise_m();
    settings.memory_s = 100.0; /* longer than the earthquake: the hardware stays the same */
    settings.correction_max_m = 0.1;
    return settings;
}

force_lead_settings lead_settings_for(const known_beforehand &known)
{
    const transfer_parameters &nominal = known.nominal;
    force_lead_settings settings{};
    settings.period_s = period_s;
    settings.model.stiffness_N_per_m = nominal.specimen_stiffness_N_per_m;
    settings.model.damping_N_s_per_m = nominal.specimen_damping_N_s_per_m();
    settings.model.mass_kg = nominal.specimen_mass_kg;
    settings.age_ticks = known.force_age_samples;
    settings.bandwidth_Hz = INFINITY;
    settings.force_max_N = nominal.force_limit_N;
    return settings;
}

} // namespace

series inverse_of(const transfer_parameters &p)
{
    series specimen = series::Zero();
    specimen.head<3>() << p.specimen_stiffness_N_per_m, p.specimen_damping_N_s_per_m(), p.specimen_mass_kg;
    series leakage = series::Zero();
    leakage.head<2>() << p.leakage_per_s, 1.0;
    series coupling = series::Zero();
    coupling(1) = p.coupling_N_per_m;
    series valve = series::Zero();
    valve.head<3>() << p.valve_spring_per_s2, p.valve_rate_per_s, 1.0;
    series command = times(valve, times(leakage, specimen) + coupling) / p.valve_gain;
    command(0) += 1.0;
    return command / p.command_gain;
}

firmware_controller::firmware_controller(const known_beforehand &known, bool leads) : leads_(leads)
{
    const inverse_settings inverse = inverse_settings_for(known.nominal);
    adaptive_inverse_start(&inverse_, &inverse, 0.0);
    const force_lead_settings lead = lead_settings_for(known);
    force_lead_start(&lead_, &lead);
    const frame whole(known.all);
    from_frame_.setZero();
    from_ground_.setZero();
    from_frame_(0, 0) = 1.0;
    for (int order = 1; order < INVERSE_TERMS_MAX; order++) {
        from_frame_.row(order) = from_frame_.row(order - 1) * whole.dynamics();
        from_ground_(order, 0) = from_frame_.row(order - 1).dot(whole.ground_input());
        from_ground_(order, 1) = from_ground_(order - 1, 0);
    }
}

series firmware_controller::derivatives(const controller_input &input)
{
    const double slope = (input.ground_m_per_s2 - ground_before_m_per_s2_) * rate_Hz;
    ground_before_m_per_s2_ = input.ground_m_per_s2;
    return from_frame_ * input.simulated + from_ground_.col(0) * input.ground_m_per_s2 + from_ground_.col(1) * slope;
}

controller_output firmware_controller::step(const controller_input &input)
{
    series now = derivatives(input);
    if (!leads_) {
        now(2) = input.target_m_per_s2; /* with a late force it moves otherwise than the whole structure */
    }
    const double command_m = adaptive_inverse_step(&inverse_, now.data());
    adaptive_inverse_learn(&inverse_, converted(command_m), input.measured_m);
    const force_lead_motion motion{now(0), now(1), now(2), now(3)};
    const double force_N = force_lead_step(&lead_, &motion, input.late_N);
    return {command_m, leads_ ? force_N : input.late_N};
}

} // namespace berth::rths
