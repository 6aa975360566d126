#include "app.h"

#include <stddef.h>

void app_start(struct app *app, const struct app_config *config)
{
    *app = (struct app){.config = *config};
    reception_start(&app->reception, &app->config);
    operator_channel_start(&app->operator_channel, &app->config);
    sensor_channel_start(&app->sensor_channel, &app->config);
    robot_channel_start(&app->robot_channel, &app->config);
    supervisor_start(&app->supervisor);
    missed_time_start(&app->missed_time, &app->config);
    refusal_start(&app->refusal, &app->config);
    reflexes_start(&app->reflexes, &app->config);
    app->recorder.tick.command_position_m = app->config.manipulator.initial_position_m;
    manipulator_start(&app->manipulator, &app->config);
    energy_account_start(&app->energy, &app->config, &app->manipulator);
    compensation_start(&app->compensation, &app->config, &app->manipulator);
    force_feedback_start(&app->force_feedback, &app->config);
    inverse_filter_start(&app->inverse_filter, &app->config);
    limits_start(&app->limits, &app->config);
    side_axes_start(&app->side_axes, &app->config);
}

/* An arm that is held takes no orders. */
static int receive_order(struct app *app, enum received_message message, const struct hal_frame *frame)
{
    struct arm_order order;
    if (!operator_channel_receive_order(&app->operator_channel, message, frame, &order)) {
        return 0;
    }
    if (supervisor_may_move(&app->supervisor)) {
        arm_motion_take(&app->manipulator.arm, &order, app->operator_channel.command.position_m);
    }
    return 1;
}

static int receive_frame(struct app *app, enum received_message message, const struct hal_frame *frame)
{
    switch (message) {
    case RECEIVED_ROBOT_FEEDBACK:
    case RECEIVED_DRIVE_STATUS:
    case RECEIVED_DRIVE_HEARTBEAT:
    case RECEIVED_DRIVE_EMERGENCY:
    case RECEIVED_SDO_ANSWER:
        return robot_channel_receive(&app->robot_channel, message, frame);
    case RECEIVED_OPERATOR_MOTION:
    case RECEIVED_OPERATOR_FORCE:
        return operator_channel_receive(&app->operator_channel, message, frame);
    case RECEIVED_OPERATOR_JOINT:
    case RECEIVED_OPERATOR_LINE:
        return receive_order(app, message, frame);
    case RECEIVED_FEEDBACK_Y:
    case RECEIVED_FEEDBACK_Z:
    case RECEIVED_FEEDBACK_RX:
    case RECEIVED_FEEDBACK_RY:
    case RECEIVED_FEEDBACK_RZ:
        return robot_channel_receive(&app->robot_channel, message, frame);
    default:
        return sensor_channel_receive(&app->sensor_channel, (int)message - RECEIVED_FORCE, frame);
    }
}

static void receive_frames(struct app *app, const struct tick_input *in)
{
    reception_begin_tick(&app->reception, in->tick.missed, in->tick.woke_ns);
    sensor_channel_begin_tick(&app->sensor_channel);
    robot_channel_begin_tick(&app->robot_channel);
    for (uint32_t i = 0; i < in->frame_count; i++) {
        const struct hal_frame *frame = &in->frames[i];
        const enum received_message message = reception_check(&app->reception, frame);
        if (message == RECEIVED_NONE) {
            continue;
        }
        if (receive_frame(app, message, frame)) {
            reception_accept(&app->reception, message, frame);
        } else {
            reception_reject_range(&app->reception);
        }
    }
    robot_channel_end_receive(&app->robot_channel, &app->reception, in->tick.scheduled_ns);
}

/* A loop that only watches takes the robot for one that is never there: it stays in start, where no setpoint is
 * sent. */
static int robot_at_place(const struct app *app)
{
    const double distance_m = app->robot_channel.position_m - app->limits.position_m;
    const double tolerance_m = app->config.robot_channel.start_tolerance_m;
    return !app->config.robot_channel.watch_only && distance_m >= -tolerance_m && distance_m <= tolerance_m &&
           side_axes_at_place(&app->side_axes, app->robot_channel.side_position);
}

/* The robot's report of this tick has come. */
static int has_report(const struct app *app)
{
    const int is_drive = app->robot_channel.profile == ROBOT_PROFILE_CIA402;
    return app->reception.in_tick[is_drive ? RECEIVED_DRIVE_STATUS : RECEIVED_ROBOT_FEEDBACK] > 0;
}

static uint32_t reflexes_of_tick(struct app *app, int64_t now_ns)
{
    const struct reflex_input in = {
        .now_ns = now_ns,
        .setpoint_m = app->recorder.tick.command_position_m,
        .reported_m = app->robot_channel.position_m,
        .has_report = has_report(app),
        .has_sample = app->sensor_channel.has_sample,
        .is_running = supervisor_may_move(&app->supervisor),
        .dead_time_J = app->energy.sums.dead_time_J,
        .stored_J = app->energy.sums.stored_J,
        .operator_J = app->energy.sums.operator_J,
    };
    return reflexes_step(&app->reflexes, &in);
}

static inline uint32_t when(int holds, enum supervisor_condition condition)
{
    return holds ? (uint32_t)condition : 0u;
}

static uint32_t supervisor_conditions(struct app *app, const struct tick_input *in)
{
    const int64_t now_ns = in->tick.scheduled_ns;
    const uint8_t request = app->operator_channel.command.request;
    const struct robot_channel *robot = &app->robot_channel;
    const struct sensor_channel *sensor = &app->sensor_channel;
    const uint32_t limited = app->limits.active | app->side_axes.active;
    const enum received_message from_operator = app->operator_channel.message;
    uint32_t set = reflexes_of_tick(app, now_ns);
    set |= when(in->emergency_stop, CONDITION_EMERGENCY_STOP);
    set |= when(in->enable, CONDITION_ENABLE);
    set |= when(in->enable == HAL_LEVEL_NOT_WIRED, CONDITION_ENABLE_NOT_WIRED);
    set |= when(robot->is_fresh, CONDITION_FEEDBACK_FRESH);
    set |= when(!sensor_channel_is_stale(sensor, now_ns), CONDITION_SENSOR_FRESH);
    set |= when(!reception_is_stale(&app->reception, from_operator, now_ns), CONDITION_OPERATOR_FRESH);
    set |= when(robot_at_place(app), CONDITION_ROBOT_AT_PLACE);
    set |= when(robot->follows, CONDITION_ROBOT_FOLLOWS);
    set |= when(robot->fault, CONDITION_ROBOT_FAULT);
    set |= when(sensor->saturated, CONDITION_SENSOR_SATURATED);
    set |= when(sensor->over_limit, CONDITION_FORCE_LIMIT);
    set |= when((limited & LIMIT_POSITION) != 0, CONDITION_POSITION_LIMIT);
    set |= when((limited & LIMIT_NOT_FINITE) != 0, CONDITION_NOT_FINITE);
    set |= when(app->reception.bus_off, CONDITION_BUS_OFF);
    set |= when(refusal_lasts(&app->refusal, now_ns), CONDITION_SEND_REFUSED);
    set |= when(robot->setpoint_is_stale, CONDITION_SETPOINT_STALE);
    set |= when(missed_time_is_over(&app->missed_time), CONDITION_MISSED_TICKS);
    set |= when(request == OPERATOR_HOLD, CONDITION_REQUEST_HOLD);
    set |= when(request == OPERATOR_RUN, CONDITION_REQUEST_RUN);
    set |= when(request == OPERATOR_RESET, CONDITION_REQUEST_RESET);
    set |= when(in->tick.stop != 0, CONDITION_STOP);
    set |= when(limits_at_rest(&app->limits) && side_axes_at_rest(&app->side_axes), CONDITION_AT_REST);
    return set;
}

/* What has to be put back when the supervisor changes state. */
static void enter_state(struct app *app, enum supervisor_state from)
{
    const enum supervisor_state to = app->supervisor.state;
    if (to == from) {
        return;
    }
    if (from == SUPERVISOR_RUNNING) {
        double side_rest[SIDE_AXIS_COUNT];
        const double rest_m = limits_stop(&app->limits);
        side_axes_stop(&app->side_axes, side_rest);
        manipulator_rest_at(&app->manipulator, rest_m);
        manipulator_call_sides(&app->manipulator, side_rest);
        compensation_rest_at(&app->compensation, rest_m);
        inverse_filter_rest_at(&app->inverse_filter, rest_m); /* its past may be not finite */
    }
    if (to == SUPERVISOR_START) {
        app->missed_ticks = 0;
        missed_time_start(&app->missed_time, &app->config);
        robot_channel_restart(&app->robot_channel);
    }
}

static void supervise(struct app *app, const struct tick_input *in)
{
    const enum supervisor_state before = app->supervisor.state;
    app->missed_ticks += in->tick.missed;
    missed_time_step(&app->missed_time, in->tick.missed);
    refusal_step(&app->refusal, in->unsent_frames, app->sent_frames, app->recorder.tick.scheduled_ns);
    app->recorder.tick.conditions = supervisor_conditions(app, in);
    supervisor_step(&app->supervisor, app->recorder.tick.conditions);
    enter_state(app, before);
    if (!app->force_feedback.is_whole) {
        force_feedback_step(&app->force_feedback, supervisor_may_move(&app->supervisor));
    }
}

/* Beside the loop's direction the measured load acts as it is: compensation is along that direction alone. */
static void load_sides(struct app *app, const double wanted[SIDE_AXIS_COUNT])
{
    const struct wrench *wrench = &app->sensor_channel.wrench;
    const double load[SIDE_AXIS_COUNT] = {wrench->force_N[1], wrench->force_N[2], wrench->torque_N_m[0],
                                          wrench->torque_N_m[1], wrench->torque_N_m[2]};
    struct energy_sides sides = {0};
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        if (app->config.side_axes[i].enabled) {
            sides.force[i] = load[i];
            sides.position[i] = app->robot_channel.side_position[i];
        }
    }
    side_record_fill(&app->side_record, wanted, app->robot_channel.side_sent, sides.position, sides.force);
    energy_account_sides(&app->energy, &sides);
    for (int i = 0; i < SIDE_AXIS_COUNT && !app->force_feedback.is_whole; i++) {
        sides.force[i] *= app->force_feedback.gain;
    }
    manipulator_load_sides(&app->manipulator, sides.force);
}

/* Beside the loop's direction; those that there are not stay at 0. */
static void command_sides(struct app *app, double wanted[SIDE_AXIS_COUNT], struct robot_command *command)
{
    manipulator_sides(&app->manipulator, wanted);
    side_axes_limit(&app->side_axes, wanted, command->side);
}

/* A loop that only watches sends its status in start, and nothing in fault, where others hold the robot. */
static int is_mute(const struct app *app)
{
    return app->config.robot_channel.watch_only && app->supervisor.state != SUPERVISOR_START;
}

static void command_robot(struct app *app, const struct tick_input *in, struct tick_output *out)
{
    struct tick_record *record = &app->recorder.tick;
    if (app->manipulator.has_arm) {
        arm_motion_record(&app->manipulator.arm, &app->arm_record);
    }
    record->manipulator_position_m = app->manipulator.position_m;
    record->manipulator_velocity_m_per_s = app->manipulator.velocity_m_per_s;
    record->displayed_position_m = compensation_motion(&app->compensation, app->manipulator.position_m);
    record->filtered_position_m = inverse_filter_step(&app->inverse_filter, record->displayed_position_m);
    struct robot_command command;
    double side[SIDE_AXIS_COUNT];
    command.position_m = limits_step(&app->limits, record->filtered_position_m);
    command.missed_ticks = app->missed_ticks;
    command.torn_samples = app->sensor_channel.torn_samples;
    command.reset_is_wanted = supervisor_hears_reset(&app->supervisor, record->conditions);
    command.enable_is_on = (record->conditions & (CONDITION_ENABLE | CONDITION_EMERGENCY_STOP)) == CONDITION_ENABLE;
    if (app->side_axes.any) {
        command_sides(app, side, &command);
    }
    command.limits = app->limits.active | app->side_axes.active;
    record->command_position_m =
        is_mute(app) ? command.position_m
                     : robot_channel_send(&app->robot_channel, &app->supervisor, &in->tick, &command, out);
    if (app->side_axes.any) {
        load_sides(app, side);
    }
}

/* The force for the manipulator's step, of the measured one. */
static void prepare_force(struct app *app)
{
    const struct operator_command *command = &app->operator_channel.command;
    const struct prediction_input in = {
        .measured_N = app->sensor_channel.force_N,
        .setpoint_m = app->recorder.tick.command_position_m,
        .reported_m = app->robot_channel.position_m,
    };
    const int may_move = supervisor_may_move(&app->supervisor);
    energy_account_book(&app->energy, command, in.measured_N, in.reported_m,
                        app->recorder.tick.displayed_position_m - app->manipulator.position_m, may_move);
    app->recorder.tick.used_force_N =
        compensation_force(&app->compensation, command, &app->energy.sums, &in, may_move);
    if (!app->force_feedback.is_whole) {
        app->recorder.tick.used_force_N *= app->force_feedback.gain;
    }
    energy_account_announce(&app->energy, command, app->recorder.tick.used_force_N, in.measured_N, may_move);
}

static void advance_manipulator(struct app *app)
{
    if (supervisor_may_move(&app->supervisor)) {
        manipulator_step(&app->manipulator, &app->operator_channel.command, app->recorder.tick.used_force_N);
    }
}

static void set_lines(struct app *app, struct tick_output *out)
{
    app->heartbeat ^= 1u;
    out->heartbeat = app->heartbeat;
    out->fault = app->supervisor.state == SUPERVISOR_FAULT;
}

static void record_energy(struct tick_record *record, const struct energy_sums *energy)
{
    record->energy_stored_J = energy->stored_J;
    record->energy_operator_J = energy->operator_J;
    record->energy_dissipated_J = energy->dissipated_J;
    record->energy_integrator_J = energy->integrator_J;
    record->energy_simulated_port_J = energy->simulated_port_J;
    record->energy_measured_port_J = energy->measured_port_J;
    record->energy_dead_time_J = energy->dead_time_J;
    record->energy_compensation_J = energy->compensation_J;
}

static void record_compensation(struct tick_record *record, const struct compensation *compensation)
{
    record->predicted_error_N = compensation->prediction.error_N;
    record->inverse_gain = compensation->inverse.coefficient[0];
    record->inverse_delay_s = compensation->inverse.coefficient[1];
    record->inverse_curve_s2 = compensation->inverse.coefficient[2];
    record->inverse_error_m = compensation->inverse.error_m;
    record->lead_error_N = compensation->lead.error_N;
    record->passivity_deficit_J = compensation->passivity.deficit_J;
    record->passivity_force_N = compensation->passivity.force_N;
    const struct believed_hardware believed = prediction_belief(&compensation->prediction);
    record->believed_mass_kg = (float)believed.mass_kg;
    record->believed_damping_N_s_per_m = (float)believed.damping_N_s_per_m;
    record->believed_stiffness_N_per_m = (float)believed.stiffness_N_per_m;
    record->believed_dead_time_ms = (float)believed.dead_time_ms;
}

static void record_drive(struct tick_record *record, const struct cia402 *drive)
{
    record->drive_error = drive->error;
    record->drive_statusword = drive->statusword;
    record->drive_trouble = drive->trouble;
    record->drive_setup_step = (uint8_t)drive->setup.step;
}

/* What a rig does without stays 0 in its record. */
static void record_tick(struct app *app, const struct tick_input *in, const struct tick_output *out)
{
    const struct operator_command *command = &app->operator_channel.command;
    const struct reception_counts *counts = &app->reception.counts;
    struct tick_record *record = &app->recorder.tick;
    record->timestamp = (uint64_t)in->tick.scheduled_ns / 1000u;
    record->index = in->tick.index;
    record->scheduled_ns = in->tick.scheduled_ns;
    record->woke_ns = in->tick.woke_ns;
    record->force_frame_age_ns = in->tick.scheduled_ns - app->sensor_channel.received_ns;
    record->operator_position_m = command->position_m;
    record->operator_velocity_m_per_s = command->velocity_m_per_s;
    record->operator_force_N = command->force_N;
    record->force_N = app->sensor_channel.force_N;
    record->robot_position_m = app->robot_channel.position_m;
    record_energy(record, &app->energy.sums);
    if (app->compensation.is_on) {
        record_compensation(record, &app->compensation);
    }
    record->missed_ticks = in->tick.missed;
    record->rejected_frames =
        counts->unknown + counts->wrong_length + counts->repeated + counts->old + counts->out_of_range;
    record->old_frames = counts->old;
    record->lost_frames = counts->lost;
    record->force_samples = app->sensor_channel.samples;
    record->torn_samples = app->sensor_channel.torn_samples;
    record->unsent_frames = in->unsent_frames;
    record->error_frames = counts->error_frames;
    record->saturated_setpoints = app->robot_channel.saturated_setpoints;
    if (app->robot_channel.profile == ROBOT_PROFILE_CIA402) {
        record_drive(record, &app->robot_channel.drive);
    }
    record->enable = in->enable;
    record->emergency_stop = in->emergency_stop;
    record->stop = in->tick.stop != 0;
    record->state = (uint8_t)app->supervisor.state;
    record->stop_cause = (uint8_t)app->supervisor.stop_cause;
    record->limits = (uint8_t)(app->limits.active | app->side_axes.active);
    record->operator_request = command->request;
    record->heartbeat = out->heartbeat;
    if (app->manipulator.has_arm) {
        app->arm_record.timestamp = app->side_record.timestamp = record->timestamp;
    }
    recorder_write(&app->recorder, in, out, app->manipulator.has_arm ? &app->arm_record : NULL,
                   app->side_axes.any ? &app->side_record : NULL);
}

void app_step(struct app *app, const struct tick_input *in, struct tick_output *out)
{
    out->frame_count = 0;
    receive_frames(app, in);
    supervise(app, in);
    command_robot(app, in, out);
    prepare_force(app);
    advance_manipulator(app);
    set_lines(app, out);
    app->sent_frames = out->frame_count;
    record_tick(app, in, out);
}
