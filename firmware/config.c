#include "config.h"

#include <float.h>
#include <stdbool.h>

#include "can/codec.h"

struct app_config config_default(void)
{
    return (struct app_config){
        .loop = {.rate_Hz = 400, .missed_ticks_budget = 20},
        .manipulator = {.mass_kg = 200.0, .integrator = INTEGRATOR_EXACT, .substeps = 1},
        .operator_command = {.interface = OPERATOR_INTERFACE_MOTION,
                             .position_limit_m = 2.0,
                             .velocity_limit_m_per_s = 2.0,
                             .force_limit_N = 5000.0,
                             .stale_after_ms = 200.0},
        .sensor_channel = {.force_limit_N = 20000.0, .stale_after_ms = 50.0},
        .robot_channel = {.stale_after_ms = 100.0, .start_tolerance_m = 0.002},
        .limits = {.position_min_m = -1.0,
                   .position_max_m = 1.0,
                   .velocity_m_per_s = 2.0,
                   .acceleration_m_per_s2 = 50.0},
        .inverse_filter = {.enabled = 0,
                           .robot_frequency_Hz = 0.0,
                           .robot_damping_ratio = 0.0,
                           .bandwidth_Hz = 40.0},
    };
}

static bool finite(double value)
{
    return value >= -DBL_MAX && value <= DBL_MAX;
}

static bool positive(double value)
{
    return finite(value) && value > 0.0;
}

static bool non_negative(double value)
{
    return finite(value) && value >= 0.0;
}

static bool within(double value, double limit)
{
    return value >= -limit && value <= limit;
}

/* A rate that is no whole number of Hz comes with as many digits as a double has. */
static bool divides_second(double rate_Hz)
{
    const double period_ns = (double)NS_PER_S / rate_Hz;
    const double whole_ns = (double)(int64_t)(period_ns + 0.5);
    const double tolerance_ns = 1e-12 * period_ns;
    return period_ns - whole_ns <= tolerance_ns && whole_ns - period_ns <= tolerance_ns;
}

struct config_error config_validate(const struct app_config *config)
{
    static const char *const must_be_positive = "must be a finite number greater than 0";
    static const char *const must_not_be_negative = "must be a finite number, 0 or more";
    static const char *const must_fit_frame = "must be within +-5.4 m, the range of the setpoint frame";
    static const char *const must_be_finite = "must be a finite number";
    const struct loop_config *loop = &config->loop;
    const struct manipulator_config *manipulator = &config->manipulator;
    const struct operator_config *command = &config->operator_command;
    const struct limits_config *limits = &config->limits;
    const struct inverse_filter_config *filter = &config->inverse_filter;

    const struct {
        bool fails;
        struct config_error error;
    } checks[] = {
        {!(loop->rate_Hz >= 1.0 && loop->rate_Hz <= 1e6), {"loop.rate_Hz", "must be from 1 to 1000000"}},
        {!(loop->rate_Hz >= 1.0 && divides_second(loop->rate_Hz)),
         {"loop.rate_Hz", "must divide 1e9, so that the period is a whole number of nanoseconds"}},
        {loop->missed_ticks_budget < 0, {"loop.missed_ticks_budget", "must be 0 or more"}},
        {!positive(manipulator->mass_kg), {"manipulator.mass_kg", must_be_positive}},
        {!non_negative(manipulator->damping_N_s_per_m), {"manipulator.damping_N_s_per_m", must_not_be_negative}},
        {!non_negative(manipulator->stiffness_N_per_m), {"manipulator.stiffness_N_per_m", must_not_be_negative}},
        {!finite(manipulator->initial_position_m), {"manipulator.initial_position_m", must_be_finite}},
        {!finite(manipulator->initial_velocity_m_per_s), {"manipulator.initial_velocity_m_per_s", must_be_finite}},
        {manipulator->integrator < 0 || manipulator->integrator >= INTEGRATOR_COUNT,
         {"manipulator.integrator", "must be exact, semi_implicit_euler or rk4"}},
        {manipulator->substeps < 1 || manipulator->substeps > 1000,
         {"manipulator.substeps", "must be from 1 to 1000"}},
        {command->interface < 0 || command->interface >= OPERATOR_INTERFACE_COUNT,
         {"operator.interface", "must be motion or force"}},
        {!positive(command->position_limit_m), {"operator.position_limit_m", must_be_positive}},
        {!positive(command->velocity_limit_m_per_s), {"operator.velocity_limit_m_per_s", must_be_positive}},
        {!positive(command->force_limit_N), {"operator.force_limit_N", must_be_positive}},
        {command->position_limit_m >= CAN_OPERATOR_POSITION_MAX_m,
         {"operator.position_limit_m", "must be less than 2.1 m, the range of the operator's frame"}},
        {command->velocity_limit_m_per_s >= CAN_OPERATOR_VELOCITY_MAX_m_per_s,
         {"operator.velocity_limit_m_per_s", "must be less than 8.3 m/s, the range of the operator's frame"}},
        {command->force_limit_N >= CAN_FORCE_MAX_N,
         {"operator.force_limit_N", "must be less than 54000 N, the range of the operator's frame"}},
        {!positive(command->stale_after_ms), {"operator.stale_after_ms", must_be_positive}},
        {!positive(config->sensor_channel.force_limit_N), {"sensor_channel.force_limit_N", must_be_positive}},
        {!positive(config->sensor_channel.stale_after_ms), {"sensor_channel.stale_after_ms", must_be_positive}},
        {!positive(config->robot_channel.stale_after_ms), {"robot_channel.stale_after_ms", must_be_positive}},
        {!positive(config->robot_channel.start_tolerance_m), {"robot_channel.start_tolerance_m", must_be_positive}},
        {!within(limits->position_min_m, CAN_POSITION_MAX_m), {"limits.position_min_m", must_fit_frame}},
        {!within(limits->position_max_m, CAN_POSITION_MAX_m), {"limits.position_max_m", must_fit_frame}},
        {limits->position_min_m >= limits->position_max_m,
         {"limits.position_min_m", "must be smaller than limits.position_max_m"}},
        {!positive(limits->velocity_m_per_s), {"limits.velocity_m_per_s", must_be_positive}},
        {!positive(limits->acceleration_m_per_s2), {"limits.acceleration_m_per_s2", must_be_positive}},
        {manipulator->initial_position_m < limits->position_min_m ||
             manipulator->initial_position_m > limits->position_max_m,
         {"manipulator.initial_position_m", "must lie within limits.position_min_m and limits.position_max_m"}},
        {filter->enabled && !positive(filter->robot_frequency_Hz),
         {"inverse_filter.enabled", "needs robot.transfer_frequency_Hz: without it there is nothing to invert"}},
        {filter->enabled && !positive(filter->robot_damping_ratio),
         {"inverse_filter.enabled", "needs robot.transfer_damping_ratio greater than 0"}},
        {filter->enabled && !(positive(filter->bandwidth_Hz) && filter->bandwidth_Hz > filter->robot_frequency_Hz),
         {"inverse_filter.bandwidth_Hz", "must be larger than robot.transfer_frequency_Hz"}},
    };
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++) {
        if (checks[i].fails) {
            return checks[i].error;
        }
    }
    return (struct config_error){NULL, NULL};
}

int64_t config_period_ns(const struct app_config *config)
{
    return (int64_t)((double)NS_PER_S / config->loop.rate_Hz + 0.5);
}

double config_period_s(const struct app_config *config)
{
    return (double)config_period_ns(config) / (double)NS_PER_S;
}

int64_t ns_from_ms(double duration_ms)
{
    return (int64_t)(duration_ms * 1e6 + 0.5);
}
