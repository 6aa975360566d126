#include "cia402_setup.h"

#include <stddef.h>

#include "canopen.h"
#include "transmission.h"

/* A single lost frame is no reason to stop. */
#define ATTEMPTS 3

/* PDOs that are looked at for a fixed mapping that fits. */
#define PDOS 4u

/* Bits of the statusword in mode homing: target reached and homing attained, and its failure. */
#define HOMING_DONE 0x1400u
#define HOMING_ERROR 0x2000u

/* Only while nothing can move but what the set-up moves; in ready the drive's mode alone is read. */
static const struct transmission_row nmt_row = {CANOPEN_NMT_ID, 2, STATE_BIT(SUPERVISOR_START)};
static const struct transmission_row sdo_row = {CANOPEN_SDO_REQUEST_ID, 8,
                                                STATE_BIT(SUPERVISOR_START) | STATE_BIT(SUPERVISOR_READY)};
/* A drive that moves by itself is stopped in every state. */
static const struct transmission_row stop_row = {CANOPEN_SDO_REQUEST_ID, 8, ~0u};

static uint32_t node_id(const struct app_config *of)
{
    return (uint32_t)of->cia402.node_id;
}

static uint32_t value_of(const struct cia402_setup *setup, const struct setup_step *step)
{
    if (step->kind == STEP_PERIOD_IN_INDEX) {
        return config_interpolation_value(setup->config, setup->period_index);
    }
    return step->value + (step->configured != NULL ? step->configured(setup->config) : 0u);
}

static uint32_t ticks_of(double duration_ms, const struct app_config *config)
{
    const int64_t ticks = ns_from_ms(duration_ms) / config_period_ns(config);
    return ticks < 1 ? 1u : (uint32_t)ticks;
}

void cia402_setup_start(struct cia402_setup *setup, const struct app_config *config)
{
    *setup = (struct cia402_setup){.config = config,
                                   .sdo_timeout_ticks = ticks_of(config->cia402.sdo_timeout_ms, config),
                                   .state_timeout_ticks = ticks_of(config->cia402.state_timeout_ms, config),
                                   .homing_timeout_ticks = ticks_of(config->cia402.homing_timeout_ms, config),
                                   .ways = cia402_configured_ways(config)};
}

static void go_to(struct cia402_setup *setup, uint32_t step)
{
    setup->step = step;
    setup->waited_ticks = 0;
    setup->in_flight_ticks = 0;
    setup->attempts = 0;
    setup->has_answer = 0;
    setup->has_booted = 0;
    setup->is_strange = 0;
    setup->segment = SEGMENT_NONE;
    setup->abort_code = 0;
}

static int is_for(const struct cia402_setup *setup, const struct setup_step *step)
{
    return (step->only_with == 0 || (setup->ways & step->only_with) != 0) && (setup->ways & step->not_with) == 0;
}

static void go_on(struct cia402_setup *setup)
{
    go_to(setup, setup->step + 1);
    while (!cia402_setup_is_whole(setup) && !is_for(setup, &cia402_steps[setup->step])) {
        setup->step++;
    }
}

void cia402_setup_restart(struct cia402_setup *setup)
{
    go_to(setup, 0);
    setup->trouble = SETUP_FINE;
    setup->is_stopping = 0;
    setup->period_value = 0;
    setup->receive_pdo = 0;
    setup->transmit_pdo = 0;
    setup->ways = cia402_configured_ways(setup->config);
    setup->ways &= setup->is_homed ? (uint16_t)~WAY_HOMING : (uint16_t)~0u;
}

void cia402_setup_booted(struct cia402_setup *setup)
{
    const int is_under_way = !cia402_setup_is_done(setup) && setup->trouble == SETUP_FINE;
    const struct setup_step *step = &cia402_steps[is_under_way ? setup->step : 0];
    const int is_asked_to = step->kind == STEP_BOOT;
    if (!is_asked_to || setup->attempts > 0) {
        setup->is_homed = 0; /* it was switched on */
    }
    if (!is_under_way) {
        return; /* a drive that falls out of its state is not set up again unasked */
    }
    if (is_asked_to) {
        setup->has_booted = setup->waited_ticks > 0;
    } else if (cia402_step_is_sdo(step) || step->kind == STEP_OPERATE || step->kind == STEP_MAY_MOVE) {
        cia402_setup_restart(setup);
    }
}

static void send_nmt(const struct cia402_setup *setup, uint8_t command, const struct supervisor *supervisor,
                     const struct hal_tick *tick, struct tick_output *out)
{
    const uint8_t data[8] = {command, (uint8_t)setup->config->cia402.node_id};
    transmit(out, &nmt_row, 0, supervisor, tick, data);
}

static void send_sdo(const struct cia402_setup *setup, const struct setup_step *step, uint8_t service,
                     uint32_t value, const struct supervisor *supervisor, const struct hal_tick *tick,
                     struct tick_output *out)
{
    uint8_t data[8] = {service};
    canopen_put(data + 1, cia402_setup_index(setup, step), 2);
    data[3] = step->subindex;
    canopen_put(data + 4, value, 4);
    transmit(out, &sdo_row, node_id(setup->config), supervisor, tick, data);
}

static void send_request(struct cia402_setup *setup, const struct setup_step *step,
                         const struct supervisor *supervisor, const struct hal_tick *tick, struct tick_output *out)
{
    switch ((enum step_kind)step->kind) {
    case STEP_SWITCH_OFF:
    case STEP_MAY_MOVE:
        break;
    case STEP_BOOT:
        setup->is_guarding = 0;
        send_nmt(setup, NMT_COMMAND_RESET_COMMUNICATION, supervisor, tick, out);
        break;
    case STEP_OPERATE:
        send_nmt(setup, NMT_COMMAND_START, supervisor, tick, out);
        break;
    case STEP_EXPECT:
    case STEP_MATCH:
    case STEP_READ_PERIOD_INDEX:
    case STEP_READ_PERIOD_VALUE:
    case STEP_HOME:
        setup->segment = SEGMENT_NONE;
        send_sdo(setup, step, SDO_UPLOAD, 0, supervisor, tick, out);
        break;
    case STEP_WRITE:
    case STEP_GUARD:
    case STEP_PERIOD:
    case STEP_PERIOD_IN_INDEX:
        setup->is_homing |= step->index == 0x6040;
        send_sdo(setup, step, (uint8_t)(SDO_DOWNLOAD + ((4u - step->length) << 2)), value_of(setup, step),
                 supervisor, tick, out);
        break;
    }
}

/* A drive whose mapping is fixed may carry the same in another of its PDOs: each is looked at from its first entry.
 */
static void match_next_pdo(struct cia402_setup *setup, const struct setup_step *step)
{
    uint8_t *pdo = step->index == 0x1600 ? &setup->receive_pdo : &setup->transmit_pdo;
    if (++*pdo >= PDOS) {
        setup->trouble = SETUP_NO_PDO;
    } else {
        go_to(setup, setup->step - step->subindex);
    }
}

/* The drive's own unit of the period, and then its value, have to make the loop's. */
static void take_period(struct cia402_setup *setup, int is_index)
{
    if (is_index) {
        setup->period_index = (int8_t)setup->answer_value;
    }
    const uint8_t wanted = config_interpolation_value(setup->config, setup->period_index);
    if (wanted != 0 && (is_index || setup->answer_value == wanted)) {
        go_on(setup);
        return;
    }
    setup->period_value = is_index ? 0 : (uint8_t)setup->answer_value;
    setup->trouble = SETUP_NO_PERIOD;
}

static void take_expected(struct cia402_setup *setup, const struct setup_step *step)
{
    if ((setup->answer_value & step->mask) == value_of(setup, step)) {
        go_on(setup);
    } else if (setup->waited_ticks > setup->state_timeout_ticks && step->reveals != 0) {
        setup->ways |= step->reveals;
        go_on(setup);
    } else if (setup->waited_ticks > setup->state_timeout_ticks) {
        setup->trouble = SETUP_WRONG_VALUE;
    }
}

static void take_homing(struct cia402_setup *setup)
{
    if ((setup->answer_value & HOMING_ERROR) != 0 || setup->waited_ticks > setup->homing_timeout_ticks) {
        setup->trouble = SETUP_HOMING;
    } else if ((setup->answer_value & HOMING_DONE) == HOMING_DONE) {
        setup->is_homed = 1;
        go_on(setup);
    }
}

/* An abort: whether the set-up can do without. */
static void take_refusal(struct cia402_setup *setup, const struct setup_step *step)
{
    const int is_missing = setup->abort_code == SDO_ABORT_NO_OBJECT || setup->abort_code == SDO_ABORT_NO_SUBINDEX;
    if (step->kind == STEP_MATCH && is_missing) {
        match_next_pdo(setup, step);
    } else if (step->refusal == MAY_BE_REFUSED || (step->refusal == MAY_BE_MISSING && is_missing) ||
               (step->refusal == MUST_WATCH && is_missing && !setup->config->cia402.must_watch_loop)) {
        setup->is_guarding |= step->kind == STEP_GUARD;
        setup->ways |= step->reveals;
        go_on(setup);
    } else {
        setup->trouble = step->refusal == MUST_WATCH && is_missing ? SETUP_UNWATCHED : SETUP_ABORTED;
    }
}

/* What an SDO answer means for its step. */
static void take_answer(struct cia402_setup *setup, const struct setup_step *step)
{
    if (setup->abort_code != 0) {
        take_refusal(setup, step);
        return;
    }
    switch ((enum step_kind)step->kind) {
    case STEP_EXPECT:
        take_expected(setup, step);
        break;
    case STEP_MATCH:
        if (setup->answer_value == value_of(setup, step)) {
            go_on(setup);
        } else {
            match_next_pdo(setup, step);
        }
        break;
    case STEP_READ_PERIOD_INDEX:
    case STEP_READ_PERIOD_VALUE:
        take_period(setup, step->kind == STEP_READ_PERIOD_INDEX);
        break;
    case STEP_HOME:
        take_homing(setup);
        break;
    default:
        setup->is_guarding |= step->kind == STEP_GUARD;
        setup->is_homing &= step->index != 0x6040 || value_of(setup, step) != 0;
        go_on(setup);
        break;
    }
}

static int state_is_reached(const struct cia402_setup *setup, const struct setup_step *step, uint8_t nmt_state,
                            int is_off)
{
    switch ((enum step_kind)step->kind) {
    case STEP_MAY_MOVE:
        return setup->may_move;
    case STEP_SWITCH_OFF:
        return (is_off && !setup->is_homing) || setup->waited_ticks > setup->state_timeout_ticks;
    case STEP_BOOT:
        return setup->has_booted;
    case STEP_OPERATE:
        return setup->waited_ticks > 0 && nmt_state == NMT_STATE_OPERATIONAL;
    default:
        return 0;
    }
}

static int request_is_late(const struct cia402_setup *setup, const struct setup_step *step)
{
    return setup->in_flight_ticks >
           (cia402_step_is_sdo(step) ? setup->sdo_timeout_ticks : setup->state_timeout_ticks);
}

/* Goes on to the next step, asks again or gets into trouble, if it is time. */
static void progress(struct cia402_setup *setup, const struct setup_step *step, uint8_t nmt_state, int is_off)
{
    if (setup->has_answer) {
        setup->has_answer = 0;
        setup->in_flight_ticks = 0;
        setup->attempts = 0;
        take_answer(setup, step);
    } else if (state_is_reached(setup, step, nmt_state, is_off)) {
        go_on(setup);
    } else if (request_is_late(setup, step)) {
        setup->in_flight_ticks = 0;
        setup->attempts += setup->attempts < ATTEMPTS;
        if (step->kind != STEP_BOOT && step->kind != STEP_MAY_MOVE && setup->attempts >= ATTEMPTS) {
            setup->trouble = setup->is_strange ? SETUP_STRANGE_ANSWER : SETUP_NO_ANSWER;
        }
    }
}

void cia402_setup_step(struct cia402_setup *setup, const struct supervisor *supervisor, const struct hal_tick *tick,
                       uint8_t nmt_state, int is_off, struct tick_output *out)
{
    if (cia402_setup_is_whole(setup) || setup->trouble != SETUP_FINE) {
        return;
    }
    const struct setup_step *before = &cia402_steps[setup->step];
    if (before->only_with == WAY_HOMING && setup->is_homing && !setup->may_move) {
        setup->trouble = SETUP_HOMING;
        return;
    }
    if (before->kind == STEP_SWITCH_OFF) {
        cia402_setup_hold(setup, supervisor, tick, out);
    }
    progress(setup, before, nmt_state, is_off);
    if ((setup->trouble == SETUP_NO_ANSWER || setup->trouble == SETUP_STRANGE_ANSWER) &&
        cia402_step_is_sdo(before)) {
        send_sdo(setup, before, SDO_ABORT, SDO_ABORT_TIMEOUT, supervisor, tick, out);
    }
    if (cia402_setup_is_whole(setup) || setup->trouble != SETUP_FINE) {
        return;
    }
    if (setup->in_flight_ticks == 0) {
        send_request(setup, &cia402_steps[setup->step], supervisor, tick, out);
    } else if (setup->segment == SEGMENT_DUE) {
        const uint8_t data[8] = {SDO_ASK_SEGMENT};
        transmit(out, &sdo_row, node_id(setup->config), supervisor, tick, data);
        setup->segment = SEGMENT_ASKED;
    }
    setup->in_flight_ticks++;
    setup->waited_ticks++;
}

void cia402_setup_hold(struct cia402_setup *setup, const struct supervisor *supervisor, const struct hal_tick *tick,
                       struct tick_output *out)
{
    if (setup->is_homing) {
        uint8_t data[8] = {SDO_DOWNLOAD + (2u << 2)};
        canopen_put(data + 1, 0x6040, 2);
        setup->is_stopping = (uint8_t)transmit(out, &stop_row, node_id(setup->config), supervisor, tick, data);
    }
}
