#include "config.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "can/codec.h"
#include "canopen.h"
#include "reflexes.h"
#include "sensor_layout.h"
#include "types.h"

struct app_config config_default(void)
{
    return (struct app_config){
        /* A loop that sleeps is as blind as one whose sensor is silent: half of what the sensor is allowed. In the
         * long run 2.5 ms a second, one tick of 400. */
        .loop = {.rate_Hz = 400, .missed_time_budget_ms = 25.0, .missed_time_refill_s = 10.0},
        .manipulator = {.mass_kg = 200.0, .integrator = INTEGRATOR_EXACT, .substeps = 1, .direction_x = 1.0},
        .operator_command = {.interface = OPERATOR_INTERFACE_MOTION,
                             .position_limit_m = 2.0,
                             .velocity_limit_m_per_s = 2.0,
                             .force_limit_N = 5000.0,
                             .stale_after_ms = 200.0},
        /* Following error: ten times start_tolerance_m, for twenty ticks at 400 Hz. Link quality: a loop that gets
         * two frames of five still follows; one that gets fewer acts on old ones. Power and growth are not bounded
         * by default: a sound bound depends on the rig, so the rig file has to set it. */
        .reflex = {.following_error_m = 0.02,
                   .following_error_ms = 50.0,
                   .link_quality = 0.4,
                   .link_quality_window_s = 2.0,
                   .dead_time_power_W = INFINITY,
                   .dead_time_power_window_s = 0.2,
                   .growth_J = INFINITY},
        .feedback = {.gain = 1.0},
        /* Pairing window: at 1 Mbit/s a frame takes at most 0.135 ms. The second of two ends 0.135 ms after the
         * first, or 0.43 ms if one that was disturbed is sent again and another node's frame goes first. */
        .sensor_channel = {.layout = SENSOR_ONE_FRAME,
                           .axis = SENSOR_AXIS_Z,
                           .rate_Hz = 0.0,
                           .force_limit_N = 20000.0,
                           .pairing_window_ms = 0.5,
                           .stale_after_ms = 50.0},
        /* A robot that does not hear is as bad as one that is not heard. What is not sent for 20 ms is longer than
         * the dead time of the paper's robot: it has run out of setpoints. */
        .robot_channel = {.profile = ROBOT_PROFILE_BERTH,
                          .stale_after_ms = 100.0,
                          .unsent_after_ms = 20.0,
                          .setpoint_stale_after_ms = 100.0,
                          .start_tolerance_m = 0.002},
        .cia402 = {.node_id = 1,
                   .master_node_id = CANOPEN_NODE_ID_MAX,
                   .counts_per_m = 1e8,
                   .heartbeat_ms = 100.0,
                   .stale_after_ms = 300.0,
                   .sdo_timeout_ms = 200.0,
                   .state_timeout_ms = 2000.0,
                   .must_watch_loop = 1,
                   .homing_timeout_ms = 60000.0},
        .limits = {.position_min_m = -1.0,
                   .position_max_m = 1.0,
                   .velocity_m_per_s = 2.0,
                   .acceleration_m_per_s2 = 50.0},
        .inverse_filter = {.enabled = 0,
                           .robot_frequency_Hz = 0.0,
                           .robot_damping_ratio = 0.0,
                           .bandwidth_Hz = 40.0},
        .energy = {.force_age_ms = 2.5, .position_age_ms = 0.0},
        .adaptive_inverse = {.tolerance = 0.3,
                             .gain_tolerance = 0.02,
                             .bandwidth_Hz = 5.0,
                             .position_noise_m = 2e-5,
                             .memory_s = 20.0,
                             .correction_max_m = 0.05},
        .force_lead = {.error_bandwidth_Hz = __builtin_inf()},
        .prediction = {.error_bandwidth_Hz = 5.0,
                       .dead_time_ms = __builtin_inf(),
                       .mass_kg = __builtin_inf(),
                       .damping_N_s_per_m = __builtin_inf(),
                       .stiffness_N_per_m = __builtin_inf()},
        .identification = {.tolerance = 0.3, .noise_N = 2.0, .position_noise_m = 2e-5, .memory_s = 20.0},
        .passivity = {.reference = PASSIVITY_MEASURED,
                      .credit_J = 1.0,
                      .horizon_ms = 50.0,
                      .damping_max_N_s_per_m = 5000.0},
    };
}

static bool is_finite(double value)
{
    return value >= -DBL_MAX && value <= DBL_MAX;
}

static bool positive(double value)
{
    return is_finite(value) && value > 0.0;
}

static bool non_negative(double value)
{
    return is_finite(value) && value >= 0.0;
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

static bool node_id(int64_t value)
{
    return value >= 1 && value <= CANOPEN_NODE_ID_MAX;
}

/* As the objects of the heartbeats carry it: 16 bits. */
static bool whole_ms(double value)
{
    return value >= 1.0 && value <= (double)UINT16_MAX && (double)(int64_t)value == value;
}

/* Frames that carry no number: those of the next sample stay outside the window. Of a layout that is one. */
static bool pairs_within_sample(const struct app_config *config)
{
    const struct sensor_channel_config *sensor = &config->sensor_channel;
    const bool is_known = sensor->layout >= 0 && sensor->layout < SENSOR_LAYOUT_COUNT;
    return !is_known || sensor_layout_is_numbered(&sensor_layouts[sensor->layout]) ||
           2 * ns_from_ms(sensor->pairing_window_ms) <= config_sample_period_ns(config);
}

static bool is_uint32(int64_t value)
{
    return value >= 0 && value <= (int64_t)UINT32_MAX;
}

/* A ratio of two 32-bit objects, or nothing. */
static bool is_ratio(int64_t numerator, int64_t denominator)
{
    return is_uint32(numerator) && is_uint32(denominator) && (numerator == 0) == (denominator == 0);
}

/* Of the profile "cia402"; looked at only if it is chosen. */
static struct config_error validate_cia402(const struct app_config *config)
{
    static const char *const must_be_node_id = "must be a node's number, from 1 to 127";
    static const char *const must_be_whole_ms = "must be a whole number of ms, from 1 to 65535";
    static const char *const must_be_ratio = "must be a whole number of 32 bits; both of a pair, or both 0";
    static const char *const must_fit_counts =
        "times cia402.counts_per_m must fit into 32 bits, the range of the target position";
    const struct cia402_config *cia402 = &config->cia402;
    const struct limits_config *limits = &config->limits;
    const double range_m = cia402->counts_per_m > 0.0 ? (double)INT32_MAX / cia402->counts_per_m : 0.0;
    const struct {
        bool fails;
        struct config_error error;
    } checks[] = {
        {!node_id(cia402->node_id), {"cia402.node_id", must_be_node_id}},
        {!node_id(cia402->master_node_id), {"cia402.master_node_id", must_be_node_id}},
        {cia402->node_id == cia402->master_node_id,
         {"cia402.master_node_id", "must not be that of the drive, cia402.node_id"}},
        {!positive(cia402->counts_per_m), {"cia402.counts_per_m", "must be a finite number greater than 0"}},
        {!within(limits->position_min_m, range_m), {"limits.position_min_m", must_fit_counts}},
        {!within(limits->position_max_m, range_m), {"limits.position_max_m", must_fit_counts}},
        {!whole_ms(cia402->heartbeat_ms), {"cia402.heartbeat_ms", must_be_whole_ms}},
        {!whole_ms(cia402->stale_after_ms), {"cia402.stale_after_ms", must_be_whole_ms}},
        {cia402->stale_after_ms <= cia402->heartbeat_ms,
         {"cia402.stale_after_ms", "must be longer than cia402.heartbeat_ms"}},
        {!positive(cia402->sdo_timeout_ms), {"cia402.sdo_timeout_ms", "must be a finite number greater than 0"}},
        {!positive(cia402->state_timeout_ms), {"cia402.state_timeout_ms", "must be a finite number greater than 0"}},
        {cia402->homing_method < INT8_MIN || cia402->homing_method > INT8_MAX,
         {"cia402.homing_method", "must be from -128 to 127, as object 0x6098; 0: none"}},
        {!positive(cia402->homing_timeout_ms),
         {"cia402.homing_timeout_ms", "must be a finite number greater than 0"}},
        {!is_ratio(cia402->encoder_counts, cia402->encoder_revolutions), {"cia402.encoder_counts", must_be_ratio}},
        {!is_ratio(cia402->gear_motor_revolutions, cia402->gear_shaft_revolutions),
         {"cia402.gear_motor_revolutions", must_be_ratio}},
        {!is_ratio(cia402->feed_counts, cia402->feed_shaft_revolutions), {"cia402.feed_counts", must_be_ratio}},
        {cia402->polarity < 0 || cia402->polarity >= POLARITY_COUNT,
         {"cia402.polarity", "must be as_it_is, normal or reversed"}},
        {config_interpolation_period(config).value == 0,
         {"loop.rate_Hz", "gives a period that object 0x60C2 of CiA 402 cannot tell: it must be 1 to 255 times a "
                          "power of ten, in ns"}},
    };
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++) {
        if (checks[i].fails) {
            return checks[i].error;
        }
    }
    return (struct config_error){NULL, NULL};
}

static bool tare_is_finite(const struct tare_config *tare)
{
    bool all = true;
    for (int i = 0; i < 3; i++) {
        all = all && is_finite(tare->force_N[i]) && is_finite(tare->torque_N_m[i]);
    }
    return all;
}

struct config_error config_validate(const struct app_config *config)
{
    static const char *const must_be_positive = "must be a finite number greater than 0";
    static const char *const must_not_be_negative = "must be a finite number, 0 or more";
    static const char *const must_fit_frame = "must be within +-5.4 m, the range of the setpoint frame";
    static const char *const must_be_finite = "must be a finite number";
    const struct loop_config *loop = &config->loop;
    const struct reflex_config *reflex = &config->reflex;
    const struct manipulator_config *manipulator = &config->manipulator;
    const struct operator_config *command = &config->operator_command;
    const struct sensor_channel_config *sensor = &config->sensor_channel;
    const struct limits_config *limits = &config->limits;
    const struct inverse_filter_config *filter = &config->inverse_filter;

    const struct {
        bool fails;
        struct config_error error;
    } checks[] = {
        {!(loop->rate_Hz >= 1.0 && loop->rate_Hz <= 1e6), {"loop.rate_Hz", "must be from 1 to 1000000"}},
        {!(loop->rate_Hz >= 1.0 && divides_second(loop->rate_Hz)),
         {"loop.rate_Hz", "must divide 1e9, so that the period is a whole number of nanoseconds"}},
        {!(loop->missed_time_budget_ms >= 0.0 && loop->missed_time_budget_ms <= 1e6),
         {"loop.missed_time_budget_ms", "must be from 0 to 1000000"}},
        {!positive(loop->missed_time_refill_s), {"loop.missed_time_refill_s", must_be_positive}},
        {!(reflex->following_error_m > 0.0),
         {"reflex.following_error_m", "must be greater than 0; inf switches it off"}},
        {!non_negative(reflex->following_error_ms), {"reflex.following_error_ms", must_not_be_negative}},
        {reflex->following_error_m <= DBL_MAX && following_delay_ticks(config) > PAST_TICKS_BEFORE_MAX,
         {"reflex.following_error_m", "needs a dead time of less than 1022 ticks; inf switches it off"}},
        {!(reflex->link_quality >= 0.0 && reflex->link_quality <= 1.0),
         {"reflex.link_quality", "must be from 0 to 1; 0 switches it off"}},
        {!positive(reflex->link_quality_window_s), {"reflex.link_quality_window_s", must_be_positive}},
        {!(reflex->dead_time_power_W > 0.0),
         {"reflex.dead_time_power_W", "must be greater than 0; inf switches it off"}},
        {!positive(reflex->dead_time_power_window_s), {"reflex.dead_time_power_window_s", must_be_positive}},
        {!(reflex->growth_J > 0.0), {"reflex.growth_J", "must be greater than 0; inf switches it off"}},
        {!(config->feedback.gain >= 0.0 && config->feedback.gain <= 1.0),
         {"feedback.gain", "must be from 0 to 1; 0: the force is not fed back"}},
        {!non_negative(config->feedback.ramp_s), {"feedback.ramp_s", must_not_be_negative}},
        {!tare_is_finite(&config->tare), {"tare", "zero and weight of the tool must be finite numbers"}},
        {!positive(manipulator->mass_kg), {"manipulator.mass_kg", must_be_positive}},
        {!non_negative(manipulator->damping_N_s_per_m), {"manipulator.damping_N_s_per_m", must_not_be_negative}},
        {!non_negative(manipulator->stiffness_N_per_m), {"manipulator.stiffness_N_per_m", must_not_be_negative}},
        {!is_finite(manipulator->initial_position_m), {"manipulator.initial_position_m", must_be_finite}},
        {!is_finite(manipulator->direction_x), {"manipulator.direction_x", must_be_finite}},
        {!is_finite(manipulator->direction_y), {"manipulator.direction_y", must_be_finite}},
        {!is_finite(manipulator->direction_z), {"manipulator.direction_z", must_be_finite}},
        {!is_finite(manipulator->initial_velocity_m_per_s),
         {"manipulator.initial_velocity_m_per_s", must_be_finite}},
        {manipulator->integrator < 0 || manipulator->integrator >= INTEGRATOR_COUNT,
         {"manipulator.integrator", "must be exact, semi_implicit_euler or rk4"}},
        {manipulator->substeps < 1 || manipulator->substeps > 1000,
         {"manipulator.substeps", "must be from 1 to 1000"}},
        {command->interface < 0 || command->interface >= OPERATOR_INTERFACE_COUNT,
         {"operator.interface", "must be motion or force"}},
        {command->bus < 0 || command->bus >= HAL_BUS_COUNT, {"operator.bus", "must be robot or sensor"}},
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
        {sensor->layout < 0 || sensor->layout >= SENSOR_LAYOUT_COUNT,
         {"sensor_channel.layout", "must be one of the layouts in sensor_layout.h"}},
        {sensor->axis < 0 || sensor->axis >= SENSOR_AXIS_COUNT, {"sensor_channel.axis", "must be x, y or z"}},
        {!(sensor->rate_Hz == 0.0 || (sensor->rate_Hz >= 1.0 && sensor->rate_Hz <= 1e5)),
         {"sensor.rate_Hz", "must be 0 (one sample a tick), or from 1 to 100000"}},
        {!positive(sensor->force_limit_N), {"sensor_channel.force_limit_N", must_be_positive}},
        {!positive(sensor->stale_after_ms), {"sensor_channel.stale_after_ms", must_be_positive}},
        {!positive(sensor->pairing_window_ms), {"sensor_channel.pairing_window_ms", must_be_positive}},
        {!pairs_within_sample(config),
         {"sensor_channel.pairing_window_ms",
          "must be at most half of the time between two samples, so that frames of "
          "two samples are not combined; make it smaller, or lower sensor.rate_Hz"}},
        {config->robot_channel.profile < 0 || config->robot_channel.profile >= ROBOT_PROFILE_COUNT,
         {"robot_channel.profile", "must be berth or cia402"}},
        {!positive(config->robot_channel.stale_after_ms), {"robot_channel.stale_after_ms", must_be_positive}},
        {!positive(config->robot_channel.unsent_after_ms), {"robot_channel.unsent_after_ms", must_be_positive}},
        {!(config->robot_channel.setpoint_stale_after_ms > 0.0),
         {"robot_channel.setpoint_stale_after_ms", "must be greater than 0; inf where the robot does not echo"}},
        {!positive(config->robot_channel.start_tolerance_m), {"robot_channel.start_tolerance_m", must_be_positive}},
        {config->robot_channel.watch_only && config->robot_channel.profile != ROBOT_PROFILE_BERTH,
         {"robot_channel.watch_only", "needs the profile berth: setting up a drive sends it setpoints"}},
        {!within(limits->position_min_m, CAN_POSITION_MAX_m), {"limits.position_min_m", must_fit_frame}},
        {!within(limits->position_max_m, CAN_POSITION_MAX_m), {"limits.position_max_m", must_fit_frame}},
        {limits->position_min_m >= limits->position_max_m,
         {"limits.position_min_m", "must be smaller than limits.position_max_m; are the two exchanged?"}},
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
        {config->arm.kind != ARM_NONE && arm_validate(&config->arm).key != NULL,
         {"manipulator.arm", "must pass arm_validate()"}},
        {!non_negative(config->energy.position_age_ms), {"energy.position_age_ms", must_not_be_negative}},
    };
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++) {
        if (checks[i].fails) {
            return checks[i].error;
        }
    }
    return config->robot_channel.profile == ROBOT_PROFILE_CIA402 ? validate_cia402(config)
                                                                 : (struct config_error){NULL, NULL};
}

int64_t config_period_ns(const struct app_config *config)
{
    return (int64_t)((double)NS_PER_S / config->loop.rate_Hz + 0.5);
}

int64_t config_sample_period_ns(const struct app_config *config)
{
    const double rate_Hz = config->sensor_channel.rate_Hz;
    return rate_Hz > 0.0 ? (int64_t)((double)NS_PER_S / rate_Hz + 0.5) : config_period_ns(config);
}

int config_leads_force(const struct app_config *config)
{
    return config->arm.kind != ARM_NONE && config->arm.force == ARM_FORCE_LED && !config->force_lead.enabled;
}

double config_force_hold_s(const struct app_config *config)
{
    return config_leads_force(config) ? 0.0 : 0.5 * config_period_s(config);
}

double config_period_s(const struct app_config *config)
{
    return (double)config_period_ns(config) / (double)NS_PER_S;
}

uint8_t config_interpolation_value(const struct app_config *config, int8_t index)
{
    const int64_t period_ns = config_period_ns(config);
    int64_t unit_ns = 1;
    if (index < -9 || index > 0) {
        return 0; /* finer than a ns, or longer than any period of a loop */
    }
    for (int i = -9; i < index; i++) {
        unit_ns *= 10;
    }
    return period_ns % unit_ns == 0 && period_ns / unit_ns <= UINT8_MAX ? (uint8_t)(period_ns / unit_ns) : 0;
}

struct interpolation_period config_interpolation_period(const struct app_config *config)
{
    static const int8_t indices[] = {-3, 0, -1, -2, -4, -5, -6, -7, -8, -9};
    for (size_t i = 0; i < sizeof indices / sizeof indices[0]; i++) {
        const uint8_t value = config_interpolation_value(config, indices[i]);
        if (value != 0) {
            return (struct interpolation_period){value, indices[i]};
        }
    }
    return (struct interpolation_period){0, 0};
}

int64_t ns_from_ms(double duration_ms)
{
    if (!(duration_ms < 1e-6 * (double)INT64_MAX)) {
        return INT64_MAX;
    }
    return (int64_t)(duration_ms * 1e6 + 0.5);
}
