#include "identification.h"

#include <algorithm>
#include <cmath>

#include "../matrix_exponential.h"

namespace
{

using vector3 = Eigen::Matrix<double, 3, 1>;
using matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/* A share of 1 of the damping where the model hardly has any: this damping ratio. */
constexpr double least_damping_ratio = 0.02;

/* The object keeps this much of mass and stiffness, whatever is identified. */
constexpr double least_left = 0.05;

/* Shares go this many tolerances away. */
constexpr double identified_tolerances_max = 3.0;

void set_low_pass(identification &id, const hardware_model &m)
{
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero(); /* state, rate, input held */
    const double w = m.low_pass_w_rad_per_s;
    if (m.low_pass_order == 2) {
        a(0, 1) = 1.0;
        a.row(1) << -w * w, -2.0 * m.low_pass_damping_ratio * w, w * w;
    } else if (m.low_pass_order == 1) {
        a.row(0) << -w, 0.0, w;
    }
    Eigen::Matrix3d over = berth::matrix_exponential<3>(a * id.period_s);
    if (m.low_pass_order == 0) {
        over.row(0) << 0.0, 0.0, 1.0;
    }
    Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>>(&id.low_pass[0][0]) = over.topRows<2>();
}

/* What each property at a share of 1 pulls, in the mean of the tick that has gone by, through the low-pass. */
void filter_forces(identification &id, const hardware_twin &twin)
{
    const double x = twin.state[TWIN_OBJECT_POSITION];
    const double v = twin.state[TWIN_OBJECT_VELOCITY];
    const double touches = hardware_touches(&twin.model, x, v) ? 1.0 : 0.0;
    const double forces[] = {0.0, touches * id.scales[IDENTIFIED_DAMPING] * v,
                             touches * id.scales[IDENTIFIED_STIFFNESS] * x};
    for (int i = 0; i < IDENTIFIED_COUNT; i++) {
        const double mean_N = i == IDENTIFIED_MASS ? id.scales[i] * (v - id.velocity_m_per_s) / id.period_s
                                                   : 0.5 * (forces[i] + id.touching[i]);
        double *const y = id.filtered[i];
        const double next = id.low_pass[0][0] * y[0] + id.low_pass[0][1] * y[1] + id.low_pass[0][2] * mean_N;
        y[1] = id.low_pass[1][0] * y[0] + id.low_pass[1][1] * y[1] + id.low_pass[1][2] * mean_N;
        y[0] = next;
        id.touching[i] = forces[i];
        past_add(&id.past_N[i], y[0]);
    }
    id.velocity_m_per_s = v;
}

/* As they were when the sample was taken, on straight lines between ticks. */
vector3 delayed_forces(const identification &id, double longer_ticks)
{
    constexpr double most = PAST_TICKS_BEFORE_MAX;
    const double ticks = std::clamp(id.delay_ticks + longer_ticks, 0.0, most);
    const auto &of = id.past_N;
    return {past_before(&of[IDENTIFIED_MASS], ticks), past_before(&of[IDENTIFIED_DAMPING], ticks),
            past_before(&of[IDENTIFIED_STIFFNESS], ticks)};
}

} // namespace

extern "C" {

void identification_start(identification *identification, const app_config *config, const hardware_model *model)
{
    *identification = {};
    struct identification &id = *identification;
    id.enabled = config->identification.enabled;
    if (!id.enabled) {
        return;
    }
    id.period_s = config_period_s(config);
    const double tolerance = config->identification.tolerance;
    const double damping = 2.0 * least_damping_ratio * std::sqrt(model->mass_kg * model->stiffness_N_per_m);
    id.scales[IDENTIFIED_MASS] = model->mass_kg;
    id.scales[IDENTIFIED_DAMPING] = std::max(damping, model->damping_N_s_per_m);
    id.scales[IDENTIFIED_STIFFNESS] = model->stiffness_N_per_m;
    id.lowest[IDENTIFIED_MASS] = id.lowest[IDENTIFIED_STIFFNESS] = least_left - 1.0;
    id.lowest[IDENTIFIED_DAMPING] = damping > model->damping_N_s_per_m ? -model->damping_N_s_per_m / damping : -1.0;
    id.highest = identified_tolerances_max * tolerance;
    id.tolerance_squared = tolerance * tolerance;
    id.noise_squared = config->identification.noise_N * config->identification.noise_N;
    id.forgetting = std::min(1.0, id.period_s / config->identification.memory_s);
    id.delay_ticks = 1e-3 * (model->setpoint_to_motion_ms + model->sample_age_ms) / id.period_s;
    set_low_pass(id, *model);
    Eigen::Map<matrix3>(&id.covariance[0][0]) = id.tolerance_squared * matrix3::Identity();
}

double identification_step(identification *identification, const hardware_twin *twin, double longer_ticks,
                           double error_N)
{
    struct identification &id = *identification;
    if (!id.enabled) {
        return error_N;
    }
    filter_forces(id, *twin);
    const vector3 forces = delayed_forces(id, longer_ticks);
    Eigen::Map<vector3> share(id.share);
    Eigen::Map<matrix3> covariance(&id.covariance[0][0]);
    const vector3 spread = covariance.lazyProduct(forces);
    const vector3 gain = spread / (forces.dot(spread) + id.noise_squared);
    share += gain * (error_N - forces.dot(share));
    covariance -= gain.lazyProduct(spread.transpose()).eval();
    covariance += id.forgetting * (id.tolerance_squared * matrix3::Identity() - covariance).eval();
    for (int i = 0; i < IDENTIFIED_COUNT; i++) {
        id.share[i] = std::clamp(id.share[i], id.lowest[i], std::max(id.highest, id.lowest[i]));
    }
    return error_N - forces.dot(share);
}

double identification_force(const identification *identification, const hardware_model *model, double depth_m,
                            double velocity_m_per_s, double acceleration_m_per_s2)
{
    const struct identification &id = *identification;
    if (!id.enabled) {
        return 0.0;
    }
    const double inertia_N = id.share[IDENTIFIED_MASS] * id.scales[IDENTIFIED_MASS] * acceleration_m_per_s2;
    if (!hardware_touches(model, depth_m, velocity_m_per_s)) {
        return inertia_N;
    }
    return inertia_N + id.share[IDENTIFIED_DAMPING] * id.scales[IDENTIFIED_DAMPING] * velocity_m_per_s +
           id.share[IDENTIFIED_STIFFNESS] * id.scales[IDENTIFIED_STIFFNESS] * depth_m;
}
}
