#include "cia402_setup.h"

#include <stddef.h>

#include "canopen.h"
#include "transmission.h"

/* A single lost frame is no reason to stop. */
#define ATTEMPTS 3

enum step_kind {
    STEP_SWITCH_OFF, /* wait until the drive is without torque; one that says nothing is not waited for */
    STEP_BOOT,       /* NMT reset communication, then its boot-up message; again and again, it may be switched off */
    STEP_WRITE,
    STEP_OFFER,           /* write; a drive without this object does without */
    STEP_WATCH,           /* write; a drive without it watches nobody: refused, unless the rig file lets it be */
    STEP_EXPECT,          /* read until value & mask is what it has to be */
    STEP_EXPECT_IF_THERE, /* a drive without this object shows later what it is */
    STEP_PERIOD, /* write a part of the period; where it is refused, the three steps below look for another way */
    STEP_READ_PERIOD_INDEX,
    STEP_PERIOD_IN_INDEX, /* write the value that goes with the drive's own index */
    STEP_READ_PERIOD_VALUE,
    STEP_OPERATE /* NMT start, then its heartbeat says operational */
};

enum segment_state {
    SEGMENT_NONE,
    SEGMENT_DUE, /* the drive has answered that it has one; it is to be asked for */
    SEGMENT_ASKED,
};

struct setup_step {
    enum step_kind kind;
    uint16_t index;
    uint8_t subindex;
    uint8_t length; /* bytes of the object */
    uint32_t value;
    uint32_t mask;                                       /* STEP_EXPECT */
    uint32_t (*configured)(const struct app_config *of); /* added to value; NULL: nothing */
};

static uint32_t node_id(const struct app_config *of)
{
    return (uint32_t)of->cia402.node_id;
}

static uint32_t heartbeat_ms(const struct app_config *of)
{
    return (uint32_t)of->cia402.heartbeat_ms;
}

static uint32_t our_heartbeat(const struct app_config *of)
{
    return (uint32_t)of->cia402.master_node_id << 16 | (uint32_t)of->cia402.stale_after_ms;
}

static uint32_t period_us(const struct app_config *of)
{
    return (uint32_t)(config_period_ns(of) / 1000);
}

static uint32_t interpolation_time(const struct app_config *of)
{
    return config_interpolation_period(of).value;
}

static uint32_t interpolation_index(const struct app_config *of)
{
    return (uint8_t)config_interpolation_period(of).index;
}

#define CONTROLWORD 0x60400010u /* object, subindex, bits: as a PDO's mapping has it */
#define STATUSWORD 0x60410010u
#define POSITION_ACTUAL_VALUE 0x60640020u
#define TARGET_POSITION 0x607a0020u
#define CYCLIC_SYNCHRONOUS_POSITION 8u
#define DEVICE_PROFILE 402u

/* clang-format off */
static const struct setup_step steps[] = {
    /*               object   sub  length  value                                            mask */
    {STEP_SWITCH_OFF, 0,      0,   0,      0,                                               0, NULL},
    {STEP_BOOT,       0,      0,   0,      0,                                               0, NULL},
    {STEP_EXPECT,    0x1000,  0,   4,      DEVICE_PROFILE,                                  0xffff, NULL},
    {STEP_EXPECT_IF_THERE, 0x6502, 0, 4,   1u << (CYCLIC_SYNCHRONOUS_POSITION - 1),         1u << (CYCLIC_SYNCHRONOUS_POSITION - 1), NULL},
    {STEP_WRITE,     0x1017,  0,   2,      0,                                               0, heartbeat_ms},
    {STEP_WATCH,     0x1016,  1,   4,      0,                                               0, our_heartbeat},
    {STEP_OFFER,     0x1006,  0,   4,      0,                                               0, period_us},

    {STEP_WRITE,     0x1400,  1,   4,      CANOPEN_PDO_DISABLED + CANOPEN_RPDO1_ID,         0, node_id},
    {STEP_WRITE,     0x1600,  0,   1,      0,                                               0, NULL},
    {STEP_WRITE,     0x1600,  1,   4,      CONTROLWORD,                                     0, NULL},
    {STEP_WRITE,     0x1600,  2,   4,      TARGET_POSITION,                                 0, NULL},
    {STEP_WRITE,     0x1600,  0,   1,      2,                                               0, NULL},
    {STEP_WRITE,     0x1400,  2,   1,      CANOPEN_PDO_EVERY_SYNC,                          0, NULL},
    {STEP_WRITE,     0x1400,  1,   4,      CANOPEN_RPDO1_ID,                                0, node_id},

    {STEP_WRITE,     0x1800,  1,   4,      CANOPEN_PDO_DISABLED + CANOPEN_PDO_NO_REMOTE + CANOPEN_TPDO1_ID, 0, node_id},
    {STEP_WRITE,     0x1a00,  0,   1,      0,                                               0, NULL},
    {STEP_WRITE,     0x1a00,  1,   4,      STATUSWORD,                                      0, NULL},
    {STEP_WRITE,     0x1a00,  2,   4,      POSITION_ACTUAL_VALUE,                           0, NULL},
    {STEP_WRITE,     0x1a00,  0,   1,      2,                                               0, NULL},
    {STEP_WRITE,     0x1800,  2,   1,      CANOPEN_PDO_EVERY_SYNC,                          0, NULL},
    {STEP_WRITE,     0x1800,  1,   4,      CANOPEN_PDO_NO_REMOTE + CANOPEN_TPDO1_ID,        0, node_id},

    {STEP_PERIOD,    0x60c2,  1,   1,      0,                                               0, interpolation_time},
    {STEP_PERIOD,    0x60c2,  2,   1,      0,                                               0, interpolation_index},
    {STEP_READ_PERIOD_INDEX, 0x60c2, 2, 1, 0,                                               0, NULL},
    {STEP_PERIOD_IN_INDEX, 0x60c2, 1, 1,   0,                                               0, NULL},
    {STEP_READ_PERIOD_VALUE, 0x60c2, 1, 1, 0,                                               0, NULL},
    {STEP_WRITE,     0x6060,  0,   1,      CYCLIC_SYNCHRONOUS_POSITION,                     0, NULL},
    {STEP_EXPECT,    0x6061,  0,   1,      CYCLIC_SYNCHRONOUS_POSITION,                     0xff, NULL},
    {STEP_OPERATE,    0,      0,   0,      0,                                               0, NULL},
};
/* clang-format on */
const uint32_t cia402_setup_steps = sizeof steps / sizeof steps[0];

/* Only while nothing can move. */
static const struct transmission_row nmt_row = {CANOPEN_NMT_ID, 2, STATE_BIT(SUPERVISOR_START)};
static const struct transmission_row sdo_row = {CANOPEN_SDO_REQUEST_ID, 8, STATE_BIT(SUPERVISOR_START)};

static int is_sdo(const struct setup_step *step)
{
    return step->index != 0;
}

static int is_read(const struct setup_step *step)
{
    return step->kind == STEP_EXPECT || step->kind == STEP_EXPECT_IF_THERE || step->kind == STEP_READ_PERIOD_INDEX ||
           step->kind == STEP_READ_PERIOD_VALUE;
}

static int is_second_way_of_period(const struct setup_step *step)
{
    return step->kind == STEP_READ_PERIOD_INDEX || step->kind == STEP_PERIOD_IN_INDEX ||
           step->kind == STEP_READ_PERIOD_VALUE;
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

uint32_t cia402_setup_object(uint32_t step)
{
    return step < cia402_setup_steps ? (uint32_t)steps[step].index << 8 | steps[step].subindex : 0;
}

void cia402_setup_start(struct cia402_setup *setup, const struct app_config *config)
{
    *setup = (struct cia402_setup){.config = config,
                                   .sdo_timeout_ticks = ticks_of(config->cia402.sdo_timeout_ms, config),
                                   .state_timeout_ticks = ticks_of(config->cia402.state_timeout_ms, config)};
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

static void go_on(struct cia402_setup *setup)
{
    go_to(setup, setup->step + 1);
    while (!cia402_setup_is_done(setup) && is_second_way_of_period(&steps[setup->step]) &&
           !setup->period_is_refused) {
        setup->step++;
    }
}

void cia402_setup_restart(struct cia402_setup *setup)
{
    go_to(setup, 0);
    setup->trouble = SETUP_FINE;
    setup->period_is_refused = 0;
    setup->period_value = 0;
}

void cia402_setup_booted(struct cia402_setup *setup)
{
    if (cia402_setup_is_done(setup) || setup->trouble != SETUP_FINE) {
        return; /* a drive that falls out of its state is not set up again unasked */
    }
    if (steps[setup->step].kind == STEP_BOOT) {
        setup->has_booted = setup->waited_ticks > 0;
    } else if (is_sdo(&steps[setup->step]) || steps[setup->step].kind == STEP_OPERATE) {
        cia402_setup_restart(setup);
    }
}

/* The value in an answer to a read: of the bytes that it says to have, or, where it says nothing, of the object's.
 */
static uint32_t expedited_value(const struct setup_step *step, const uint8_t data[8])
{
    const uint32_t given = (data[0] & SDO_SIZE_IS_TOLD) != 0 ? 4u - (data[0] >> 2 & 3u) : step->length;
    return canopen_get(data + 4, given < step->length ? given : step->length);
}

static int take_value(struct cia402_setup *setup, uint32_t value)
{
    setup->answer_value = value;
    setup->has_answer = 1;
    return 1;
}

/* A segment with all of the object, as an object of up to seven bytes needs no other. It names no object. */
static int receive_segment(struct cia402_setup *setup, const struct setup_step *step, const uint8_t data[8])
{
    const uint32_t given = 7u - (data[0] >> 1 & 7u);
    if ((data[0] & ~SDO_SEGMENT_SIZE) != SDO_LAST_SEGMENT) {
        setup->is_strange = 1;
        return 0;
    }
    setup->segment = SEGMENT_NONE;
    return take_value(setup, canopen_get(data + 1, given < step->length ? given : step->length));
}

int cia402_setup_receive(struct cia402_setup *setup, const uint8_t data[8])
{
    if (cia402_setup_is_done(setup) || setup->trouble != SETUP_FINE || setup->in_flight_ticks == 0 ||
        setup->has_answer) {
        return 0;
    }
    const struct setup_step *step = &steps[setup->step];
    const uint8_t service = data[0] & SDO_SERVICE;
    if (setup->segment == SEGMENT_ASKED && service == SDO_SEGMENT) {
        return receive_segment(setup, step, data);
    }
    if (!is_sdo(step) || canopen_get(data + 1, 2) != step->index || data[3] != step->subindex) {
        return 0;
    }
    if (data[0] == SDO_ABORT) {
        setup->abort_code = canopen_get(data + 4, 4);
        return take_value(setup, 0);
    }
    if (!is_read(step) && service == SDO_DOWNLOADED) {
        return take_value(setup, 0);
    }
    if (is_read(step) && service == SDO_UPLOAD_ANSWER && (data[0] & SDO_IS_EXPEDITED) != 0) {
        return take_value(setup, expedited_value(step, data));
    }
    if (is_read(step) && service == SDO_UPLOAD_ANSWER && setup->segment == SEGMENT_NONE) {
        setup->segment = SEGMENT_DUE;
        return 1;
    }
    setup->is_strange = 1;
    return 0;
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
    canopen_put(data + 1, step->index, 2);
    data[3] = step->subindex;
    canopen_put(data + 4, value, 4);
    transmit(out, &sdo_row, node_id(setup->config), supervisor, tick, data);
}

static void send_request(struct cia402_setup *setup, const struct setup_step *step,
                         const struct supervisor *supervisor, const struct hal_tick *tick, struct tick_output *out)
{
    switch (step->kind) {
    case STEP_SWITCH_OFF:
        break;
    case STEP_BOOT:
        send_nmt(setup, NMT_COMMAND_RESET_COMMUNICATION, supervisor, tick, out);
        break;
    case STEP_OPERATE:
        send_nmt(setup, NMT_COMMAND_START, supervisor, tick, out);
        break;
    case STEP_EXPECT:
    case STEP_EXPECT_IF_THERE:
    case STEP_READ_PERIOD_INDEX:
    case STEP_READ_PERIOD_VALUE:
        setup->segment = SEGMENT_NONE;
        send_sdo(setup, step, SDO_UPLOAD, 0, supervisor, tick, out);
        break;
    case STEP_WRITE:
    case STEP_OFFER:
    case STEP_WATCH:
    case STEP_PERIOD:
    case STEP_PERIOD_IN_INDEX:
        send_sdo(setup, step, (uint8_t)(SDO_DOWNLOAD + ((4u - step->length) << 2)), value_of(setup, step),
                 supervisor, tick, out);
        break;
    }
}

/* How a step of the period ends: the drive may know it in another unit, or have it already. */
static void take_period_answer(struct cia402_setup *setup, const struct setup_step *step)
{
    switch (step->kind) {
    case STEP_PERIOD:
        setup->period_is_refused = setup->period_is_refused || setup->abort_code != 0;
        break;
    case STEP_READ_PERIOD_INDEX:
        setup->period_index = (int8_t)setup->answer_value;
        if (config_interpolation_value(setup->config, setup->period_index) == 0) {
            setup->trouble = SETUP_NO_PERIOD;
        }
        break;
    case STEP_READ_PERIOD_VALUE:
        if (setup->answer_value != config_interpolation_value(setup->config, setup->period_index)) {
            setup->period_value = (uint8_t)setup->answer_value;
            setup->trouble = SETUP_NO_PERIOD;
        }
        break;
    default: /* of the write in the drive's own index the value that is read back tells */
        break;
    }
    if (setup->trouble == SETUP_FINE) {
        go_on(setup);
    }
}

/* What an SDO answer means for its step. */
static void take_answer(struct cia402_setup *setup, const struct setup_step *step)
{
    const int is_missing = setup->abort_code == SDO_ABORT_NO_OBJECT || setup->abort_code == SDO_ABORT_NO_SUBINDEX;
    const int may_be_missing =
        step->kind == STEP_OFFER || step->kind == STEP_WATCH || step->kind == STEP_EXPECT_IF_THERE;
    const int may_be_refused = step->kind == STEP_PERIOD || step->kind == STEP_PERIOD_IN_INDEX;
    if (step->kind == STEP_WATCH && is_missing && setup->config->cia402.must_watch_loop) {
        setup->trouble = SETUP_UNWATCHED;
    } else if (setup->abort_code != 0 && !(may_be_missing && is_missing) && !may_be_refused) {
        setup->trouble = SETUP_ABORTED;
    } else if (may_be_refused || is_second_way_of_period(step)) {
        take_period_answer(setup, step);
    } else if (!is_read(step) || setup->abort_code != 0 || (setup->answer_value & step->mask) == step->value) {
        go_on(setup);
    } else if (setup->waited_ticks > setup->state_timeout_ticks) {
        setup->trouble = SETUP_WRONG_VALUE;
    }
}

static int state_is_reached(const struct cia402_setup *setup, const struct setup_step *step, uint8_t nmt_state,
                            int is_off)
{
    switch (step->kind) {
    case STEP_SWITCH_OFF:
        return is_off || setup->waited_ticks > setup->state_timeout_ticks;
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
    return setup->in_flight_ticks > (is_sdo(step) ? setup->sdo_timeout_ticks : setup->state_timeout_ticks);
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
        if (step->kind != STEP_BOOT && ++setup->attempts >= ATTEMPTS) {
            setup->trouble = setup->is_strange ? SETUP_STRANGE_ANSWER : SETUP_NO_ANSWER;
        }
    }
}

void cia402_setup_step(struct cia402_setup *setup, const struct supervisor *supervisor, const struct hal_tick *tick,
                       uint8_t nmt_state, int is_off, struct tick_output *out)
{
    if (cia402_setup_is_done(setup) || setup->trouble != SETUP_FINE) {
        return;
    }
    const struct setup_step *before = &steps[setup->step];
    progress(setup, before, nmt_state, is_off);
    if ((setup->trouble == SETUP_NO_ANSWER || setup->trouble == SETUP_STRANGE_ANSWER) && is_sdo(before)) {
        send_sdo(setup, before, SDO_ABORT, SDO_ABORT_TIMEOUT, supervisor, tick, out);
    }
    if (cia402_setup_is_done(setup) || setup->trouble != SETUP_FINE) {
        return;
    }
    if (setup->in_flight_ticks == 0) {
        send_request(setup, &steps[setup->step], supervisor, tick, out);
    } else if (setup->segment == SEGMENT_DUE) {
        const uint8_t data[8] = {SDO_ASK_SEGMENT};
        transmit(out, &sdo_row, node_id(setup->config), supervisor, tick, data);
        setup->segment = SEGMENT_ASKED;
    }
    setup->in_flight_ticks++;
    setup->waited_ticks++;
}
