#include "cia402_steps.h"

#include <stddef.h>

#include "canopen.h"

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

/* The drive may miss so many polls: those of stale_after_ms, rounded up. */
static uint32_t life_time_factor(const struct app_config *of)
{
    const uint32_t heartbeat = heartbeat_ms(of);
    const uint32_t factor = ((uint32_t)of->cia402.stale_after_ms + heartbeat - 1u) / heartbeat;
    return factor < UINT8_MAX ? factor : UINT8_MAX;
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

static uint32_t encoder_counts(const struct app_config *of)
{
    return (uint32_t)of->cia402.encoder_counts;
}

static uint32_t encoder_revolutions(const struct app_config *of)
{
    return (uint32_t)of->cia402.encoder_revolutions;
}

static uint32_t gear_motor_revolutions(const struct app_config *of)
{
    return (uint32_t)of->cia402.gear_motor_revolutions;
}

static uint32_t gear_shaft_revolutions(const struct app_config *of)
{
    return (uint32_t)of->cia402.gear_shaft_revolutions;
}

static uint32_t feed_counts(const struct app_config *of)
{
    return (uint32_t)of->cia402.feed_counts;
}

static uint32_t feed_shaft_revolutions(const struct app_config *of)
{
    return (uint32_t)of->cia402.feed_shaft_revolutions;
}

#define POLARITY_OF_POSITION 0x80u

static uint32_t polarity(const struct app_config *of)
{
    return of->cia402.polarity == POLARITY_REVERSED ? POLARITY_OF_POSITION : 0u;
}

static uint32_t homing_method(const struct app_config *of)
{
    return (uint8_t)of->cia402.homing_method;
}

#define CONTROLWORD 0x60400010u /* object, subindex, bits: as a PDO's mapping has it */
#define STATUSWORD 0x60410010u
#define POSITION_ACTUAL_VALUE 0x60640020u
#define TARGET_POSITION 0x607a0020u
#define HOMING 6u
#define CYCLIC_SYNCHRONOUS_POSITION 8u
#define MODE_BIT (1u << (CYCLIC_SYNCHRONOUS_POSITION - 1)) /* in 0x6502 */
#define DEVICE_PROFILE 402u
#define ALL 0xffffffffu

/* clang-format off */
#define OBJECT(number, sub, bytes) .index = (number), .subindex = (sub), .length = (bytes)
#define WRITE(number, sub, bytes, what) .kind = STEP_WRITE, OBJECT(number, sub, bytes), .value = (what)
#define WRITE_OF(number, sub, bytes, from) .kind = STEP_WRITE, OBJECT(number, sub, bytes), .configured = (from)
#define EXPECT(number, sub, bytes, bits, what) \
    .kind = STEP_EXPECT, OBJECT(number, sub, bytes), .mask = (bits), .value = (what)
#define EXPECT_OF(number, sub, bytes, bits, from) \
    .kind = STEP_EXPECT, OBJECT(number, sub, bytes), .mask = (bits), .configured = (from)
#define MATCH(number, sub, bytes, what, way) \
    .kind = STEP_MATCH, OBJECT(number, sub, bytes), .mask = ALL, .value = (what), .only_with = (way)

/* A factor that the drive does not let be written may be right as it is. */
#define FACTOR(number, sub, bytes, bits, from, way) \
    {WRITE_OF(number, sub, bytes, from), .refusal = MAY_BE_REFUSED, .only_with = (way)}, \
    {EXPECT_OF(number, sub, bytes, bits, from), .only_with = (way)}

/* The mapping of a PDO: two objects of 6 bytes, sent or taken with each SYNC. Where it is fixed, the first PDO with
 * just these objects is used, under the identifier of PDO 1. */
#define PDO(parameter, mapping, identifier, first, second, fixed) \
    {WRITE(parameter, 1, 4, CANOPEN_PDO_DISABLED + (identifier)), .configured = node_id}, \
    {WRITE(mapping, 0, 1, 0), .refusal = MAY_BE_REFUSED, .reveals = (fixed)}, \
    {WRITE(mapping, 1, 4, first), .not_with = (fixed)}, \
    {WRITE(mapping, 2, 4, second), .not_with = (fixed)}, \
    {WRITE(mapping, 0, 1, 2), .not_with = (fixed)}, \
    {MATCH(mapping, 0, 1, 2, fixed)}, \
    {MATCH(mapping, 1, 4, first, fixed)}, \
    {MATCH(mapping, 2, 4, second, fixed)}, \
    {WRITE(parameter, 1, 4, CANOPEN_PDO_DISABLED + (identifier)), .configured = node_id, .only_with = (fixed)}, \
    {WRITE(parameter, 2, 1, CANOPEN_PDO_EVERY_SYNC)}, \
    {WRITE(parameter, 1, 4, identifier), .configured = node_id}

#define HOME_WRITE(what) {WRITE(0x6040, 0, 2, what), .only_with = WAY_HOMING}
#define HOME_EXPECT(bits, what) {EXPECT(0x6041, 0, 2, bits, what), .only_with = WAY_HOMING}

const struct setup_step cia402_steps[] = {
    {.kind = STEP_SWITCH_OFF},
    {.kind = STEP_BOOT},
    {EXPECT(0x1000, 0, 4, 0xffff, DEVICE_PROFILE)},
    {EXPECT(0x6502, 0, 4, MODE_BIT, MODE_BIT), .refusal = MAY_BE_MISSING},
    {WRITE_OF(0x1017, 0, 2, heartbeat_ms), .refusal = MAY_BE_MISSING, .reveals = WAY_GUARDED},
    {WRITE_OF(0x1016, 1, 4, our_heartbeat), .refusal = MUST_WATCH, .not_with = WAY_GUARDED},
    {WRITE_OF(0x100c, 0, 2, heartbeat_ms), .only_with = WAY_GUARDED},
    {.kind = STEP_GUARD, OBJECT(0x100d, 0, 1), .configured = life_time_factor, .refusal = MUST_WATCH, .only_with = WAY_GUARDED},
    {WRITE_OF(0x1006, 0, 4, period_us), .refusal = MAY_BE_MISSING},

    PDO(0x1400, 0x1600, CANOPEN_RPDO1_ID, CONTROLWORD, TARGET_POSITION, WAY_FIXED_RECEIVE),
    PDO(0x1800, 0x1a00, CANOPEN_PDO_NO_REMOTE + CANOPEN_TPDO1_ID, STATUSWORD, POSITION_ACTUAL_VALUE, WAY_FIXED_TRANSMIT),

    FACTOR(0x608f, 1, 4, ALL, encoder_counts, WAY_ENCODER),
    FACTOR(0x608f, 2, 4, ALL, encoder_revolutions, WAY_ENCODER),
    FACTOR(0x6091, 1, 4, ALL, gear_motor_revolutions, WAY_GEAR),
    FACTOR(0x6091, 2, 4, ALL, gear_shaft_revolutions, WAY_GEAR),
    FACTOR(0x6092, 1, 4, ALL, feed_counts, WAY_FEED),
    FACTOR(0x6092, 2, 4, ALL, feed_shaft_revolutions, WAY_FEED),
    FACTOR(0x607e, 0, 1, POLARITY_OF_POSITION, polarity, WAY_POLARITY),

    /* The drive's own motion, led by SDO: no PDO is obeyed before NMT start. */
    {WRITE_OF(0x6098, 0, 1, homing_method), .only_with = WAY_HOMING},
    {WRITE(0x6060, 0, 1, HOMING), .only_with = WAY_HOMING},
    {.kind = STEP_MAY_MOVE, .only_with = WAY_HOMING},
    HOME_WRITE(0x06),
    HOME_EXPECT(0x6f, 0x21),
    HOME_WRITE(0x07),
    HOME_EXPECT(0x6f, 0x23),
    HOME_WRITE(0x0f),
    HOME_EXPECT(0x6f, 0x27),
    HOME_WRITE(0x1f),
    {.kind = STEP_HOME, OBJECT(0x6041, 0, 2), .only_with = WAY_HOMING},
    HOME_WRITE(0x00),
    HOME_EXPECT(0x4f, 0x40),

    {.kind = STEP_PERIOD, OBJECT(0x60c2, 1, 1), .configured = interpolation_time, .refusal = MAY_BE_REFUSED, .reveals = WAY_OWN_PERIOD},
    {.kind = STEP_PERIOD, OBJECT(0x60c2, 2, 1), .configured = interpolation_index, .refusal = MAY_BE_REFUSED, .reveals = WAY_OWN_PERIOD},
    {.kind = STEP_READ_PERIOD_INDEX, OBJECT(0x60c2, 2, 1), .only_with = WAY_OWN_PERIOD},
    {.kind = STEP_PERIOD_IN_INDEX, OBJECT(0x60c2, 1, 1), .refusal = MAY_BE_REFUSED, .only_with = WAY_OWN_PERIOD},
    {.kind = STEP_READ_PERIOD_VALUE, OBJECT(0x60c2, 1, 1), .only_with = WAY_OWN_PERIOD},
    {WRITE(0x6060, 0, 1, CYCLIC_SYNCHRONOUS_POSITION)},
    {EXPECT(0x6061, 0, 1, 0xff, CYCLIC_SYNCHRONOUS_POSITION), .refusal = MAY_BE_MISSING, .reveals = WAY_LATE_MODE},
    {.kind = STEP_OPERATE},

    {EXPECT(0x6061, 0, 1, 0xff, CYCLIC_SYNCHRONOUS_POSITION), .refusal = MAY_BE_MISSING, .only_with = WAY_LATE_MODE},
};
/* clang-format on */
const uint32_t cia402_all_steps = sizeof cia402_steps / sizeof cia402_steps[0];
const uint32_t cia402_setup_steps = sizeof cia402_steps / sizeof cia402_steps[0] - 1;

uint32_t cia402_setup_object(uint32_t step)
{
    return step < cia402_all_steps ? (uint32_t)cia402_steps[step].index << 8 | cia402_steps[step].subindex : 0;
}

uint16_t cia402_configured_ways(const struct app_config *config)
{
    const struct cia402_config *cia402 = &config->cia402;
    const struct {
        int is_chosen;
        enum setup_way way;
    } choices[] = {
        {cia402->homing_method != 0, WAY_HOMING},
        {cia402->encoder_counts != 0, WAY_ENCODER},
        {cia402->gear_motor_revolutions != 0, WAY_GEAR},
        {cia402->feed_counts != 0, WAY_FEED},
        {cia402->polarity != POLARITY_AS_IT_IS, WAY_POLARITY},
    };
    uint16_t ways = 0;
    for (size_t i = 0; i < sizeof choices / sizeof choices[0]; i++) {
        ways |= choices[i].is_chosen ? (uint16_t)choices[i].way : 0u;
    }
    return ways;
}
