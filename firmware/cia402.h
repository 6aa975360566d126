/* Robot channel profile "cia402": the loop as CANopen master of one CiA 402 drive in cyclic synchronous position.
 * Each tick begins with SYNC: the drive takes the setpoint of the tick before and answers with statusword and
 * position; then follows this tick's setpoint, which acts at the next SYNC. Positions in counts on the wire, in m
 * here. Sources: CiA 301, CiA 402. */
#ifndef FIRMWARE_CIA402_H
#define FIRMWARE_CIA402_H

#include "cia402_setup.h"
#include "reception.h"

#ifdef __cplusplus
extern "C" {
#endif

/* States of the drive by its statusword. */
enum cia402_state {
    DRIVE_NOT_READY_TO_SWITCH_ON,
    DRIVE_SWITCH_ON_DISABLED,
    DRIVE_READY_TO_SWITCH_ON,
    DRIVE_SWITCHED_ON,
    DRIVE_OPERATION_ENABLED,
    DRIVE_QUICK_STOP_ACTIVE,
    DRIVE_FAULT_REACTION_ACTIVE,
    DRIVE_FAULT,
    DRIVE_STATE_COUNT,
    DRIVE_UNKNOWN = DRIVE_STATE_COUNT /* no statusword since the set-up, or none of these */
};

/* What is wrong with the drive: each is a robot fault to the supervisor. */
enum cia402_trouble {
    DRIVE_TROUBLE_NONE,
    DRIVE_TROUBLE_SDO_ABORT,
    DRIVE_TROUBLE_NO_ANSWER,
    DRIVE_TROUBLE_WRONG_VALUE,
    DRIVE_TROUBLE_EMERGENCY,       /* an EMCY that has not been taken back */
    DRIVE_TROUBLE_HEARTBEAT,       /* none for too long */
    DRIVE_TROUBLE_NOT_OPERATIONAL, /* has left the NMT state operational */
    DRIVE_TROUBLE_FAULT,           /* 402 state fault or fault reaction active */
    DRIVE_TROUBLE_NOT_ENABLED,     /* does not get to operation enabled in time */
    DRIVE_TROUBLE_DROPPED_OUT,     /* has left operation enabled unasked */
    DRIVE_TROUBLE_STRANGE_ANSWER,  /* answers its set-up, and not as the standard has it */
    DRIVE_TROUBLE_NO_PERIOD,       /* cannot tell the loop's period */
    DRIVE_TROUBLE_UNWATCHED,       /* would not stop when the loop dies */
    DRIVE_TROUBLE_NO_PDO,          /* none of its fixed PDOs fits */
    DRIVE_TROUBLE_HOMING,
    DRIVE_TROUBLE_COUNT
};

struct cia402 {
    const struct app_config *config;
    struct cia402_setup setup;
    double position_m;
    int64_t bridge_counts; /* from the setpoint of the loop to the one that is sent, see bridge() */
    int64_t bridge_step_counts;
    int32_t position_counts;
    uint16_t statusword;
    uint16_t error_code; /* of the newest EMCY; 0: taken back, or none */
    uint8_t state;       /* enum cia402_state */
    uint8_t nmt_state;
    uint8_t trouble;      /* enum cia402_trouble: the first that came, until a reset */
    uint8_t was_enabled;  /* since the set-up */
    uint8_t guard_toggle; /* that the next answer to a poll has to carry */
    uint32_t error; /* SDO abort code or EMCY error code that came with the trouble, the value that the drive holds,
                       or the period that it knows, see cia402_period_error(); 0: none */
    uint32_t enabling_ticks;
    uint32_t heartbeat_period_ticks;
    uint32_t saturated_setpoints;
};

void cia402_start(struct cia402 *drive, const struct app_config *config);

/* The drive is to be set up anew; before that, to be switched off. */
void cia402_restart(struct cia402 *drive);

/* Takes a checked frame. 0 if what it says cannot be: it is to be rejected. */
int cia402_receive(struct cia402 *drive, enum received_message message, const struct hal_frame *frame);

/* After the last frame of a tick: what is wrong now. */
void cia402_judge(struct cia402 *drive, int heartbeat_is_stale);

/* Set up, and it has told its state since. */
static inline int cia402_is_ready(const struct cia402 *drive)
{
    return cia402_setup_is_done(&drive->setup) && drive->state != DRIVE_UNKNOWN;
}

static inline int cia402_is_enabled(const struct cia402 *drive)
{
    return drive->state == DRIVE_OPERATION_ENABLED;
}

/* It follows the loop's setpoints: enabled, in the right mode, and led from where it was to where they are. */
static inline int cia402_follows(const struct cia402 *drive)
{
    return cia402_is_enabled(drive) && cia402_setup_is_whole(&drive->setup) && drive->bridge_counts == 0;
}

/* Appends the frames of this tick and returns the position that the setpoint frame carries, in m. */
double cia402_send(struct cia402 *drive, const struct supervisor *supervisor, const struct hal_tick *tick,
                   double command_position_m, int reset_is_wanted, struct tick_output *out);

/* The drive's own interpolation period as an error: value * 10^index s; value 0: any, in this unit. */
static inline uint32_t cia402_period_error(uint8_t value, int8_t index)
{
    return (uint32_t)value << 8 | (uint8_t)index;
}

enum cia402_state cia402_state_of(uint16_t statusword);
const char *cia402_state_name(enum cia402_state state);
const char *cia402_trouble_name(enum cia402_trouble trouble);

#ifdef __cplusplus
}
#endif
#endif
