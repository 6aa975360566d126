#include "force_lead.h"

#include <algorithm>
#include <cmath>

#include "../matrix_exponential.h"
#include "../pi.h"
#include "delay_shares.h"
#include "hardware_twin.h"

namespace
{

double age_ticks(const app_config &config)
{
    return 1e-3 * force_lead_age_ms(&config) / config_period_s(&config);
}

} // namespace

extern "C" {

force_lead_settings force_lead_settings_of(const app_config *config)
{
    force_lead_settings settings{};
    settings.period_s = config_period_s(config);
    settings.model = config->hardware;
    settings.age_ticks = age_ticks(*config);
    settings.bandwidth_Hz = config->force_lead.error_bandwidth_Hz;
    settings.force_max_N = config->sensor_channel.force_limit_N;
    return settings;
}

int force_lead_fits(const app_config *config)
{
    return age_ticks(*config) < PAST_TICKS_BEFORE_MAX;
}

void force_lead_start(force_lead *lead, const force_lead_settings *settings)
{
    *lead = {};
    lead->settings = *settings;
    lead->error_share = 1.0;
    if (std::isfinite(settings->bandwidth_Hz)) {
        Eigen::Matrix<double, 1, 1> decay;
        decay << -berth::two_pi * settings->bandwidth_Hz * settings->period_s;
        lead->error_share = 1.0 - berth::matrix_exponential<1>(decay)(0, 0);
    }
}

void force_lead_rest(force_lead *lead)
{
    lead->is_filled = 0;
    lead->fed_back_N = 0.0;
}

double force_lead_step(force_lead *lead, const force_lead_motion *motion, double measured_N)
{
    const force_lead_settings &s = lead->settings;
    const hardware_model &m = s.model;
    const bool touches = hardware_touches(&m, motion->position_m, motion->velocity_m_per_s) != 0;
    const double k = touches ? m.stiffness_N_per_m : 0.0;
    const double d = touches ? m.damping_N_s_per_m : 0.0;
    const double now_N =
        k * motion->position_m + d * motion->velocity_m_per_s + m.mass_kg * motion->acceleration_m_per_s2;
    const double rate_N_per_s =
        k * motion->velocity_m_per_s + d * motion->acceleration_m_per_s2 + m.mass_kg * motion->jerk_m_per_s3;
    if (!lead->is_filled) {
        past_fill(&lead->model_N, now_N);
        lead->is_filled = 1;
    }
    past_add(&lead->model_N, now_N);
    lead->error_N = measured_N - past_before(&lead->model_N, s.age_ticks);
    lead->fed_back_N += lead->error_share * (lead->error_N - lead->fed_back_N);
    const double wanted_N = now_N + 0.5 * s.period_s * rate_N_per_s + lead->fed_back_N;
    const double force_N = std::clamp(wanted_N, -s.force_max_N, s.force_max_N);
    lead->saturated += force_N != wanted_N;
    return force_N;
}
}
