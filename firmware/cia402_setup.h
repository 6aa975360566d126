/* Sets a CiA 402 drive up for cyclic synchronous position, step by step by the table of cia402_steps.h: NMT
 * commands, and objects written and read by expedited SDO. One step at a time, at most one request in flight, every
 * wait counted in ticks. Sources: CiA 301, CiA 402. */
#ifndef FIRMWARE_CIA402_SETUP_H
#define FIRMWARE_CIA402_SETUP_H

#include "cia402_steps.h"
#include "supervisor.h"
#include "types.h"

#ifdef __cplusplus
extern "C" {
#endif

enum cia402_setup_trouble {
    SETUP_FINE,
    SETUP_ABORTED,        /* the drive has refused an object: its abort code is kept */
    SETUP_NO_ANSWER,      /* or not the expected state within its time */
    SETUP_WRONG_VALUE,    /* an object is not what it has to be: no drive for this profile */
    SETUP_STRANGE_ANSWER, /* none but one that no server may give */
    SETUP_NO_PERIOD,      /* 0x60C2 cannot tell the loop's period */
    SETUP_UNWATCHED,      /* no object 0x1016, or 0x100D: it would not stop when the loop dies */
    SETUP_NO_PDO,         /* the mapping of its PDOs is fixed, and none carries what the loop needs */
    SETUP_HOMING          /* the homing has failed, or was not permitted to go on */
};

enum segment_state {
    SEGMENT_NONE,
    SEGMENT_DUE, /* the drive has answered that it has one; it is to be asked for */
    SEGMENT_ASKED,
};

struct cia402_setup {
    const struct app_config *config;
    uint32_t step;            /* number of the step; from cia402_setup_steps on the drive may be enabled */
    uint32_t waited_ticks;    /* in this step */
    uint32_t in_flight_ticks; /* since its request was sent; 0: it has not been */
    uint32_t sdo_timeout_ticks;
    uint32_t state_timeout_ticks;
    uint32_t homing_timeout_ticks;
    uint8_t attempts;     /* of this step's request, that have got no answer */
    uint8_t has_answer;   /* an SDO answer to the request in flight */
    uint8_t has_booted;   /* since the step began */
    uint8_t trouble;      /* enum cia402_setup_trouble; the set-up stands still */
    uint8_t is_strange;   /* an answer to this step that is none of the standard */
    uint8_t segment;      /* enum segment_state: an answer that comes in segments */
    int8_t period_index;  /* the drive's own, read back */
    uint8_t period_value; /* the drive's own, read back; 0: not read */
    uint8_t is_guarding;  /* the drive expects to be polled */
    uint8_t is_homing;    /* it moves by itself, until the controlword 0 has been answered */
    uint8_t is_stopping;  /* that controlword has been sent */
    uint8_t is_homed;     /* and has not been switched off since */
    uint8_t may_move;     /* the enable line is there, and no emergency stop: set before each step */
    uint8_t receive_pdo;  /* whose fixed mapping fits, counted from 0 */
    uint8_t transmit_pdo;
    uint16_t ways; /* set of enum setup_way */
    uint32_t answer_value;
    uint32_t abort_code;
};

void cia402_setup_start(struct cia402_setup *setup, const struct app_config *config);

/* From the first step on, with all that went wrong forgotten. */
void cia402_setup_restart(struct cia402_setup *setup);

/* The drive may have been without power: a homing is done again. */
static inline void cia402_setup_forget_home(struct cia402_setup *setup)
{
    setup->is_homed = 0;
}

/* The object of a step; of a PDO that of the one that is looked at. */
static inline uint16_t cia402_setup_index(const struct cia402_setup *setup, const struct setup_step *step)
{
    const uint16_t object = step->index;
    const int receives = object == 0x1400 || object == 0x1600;
    const int transmits = object == 0x1800 || object == 0x1a00;
    return (uint16_t)(object + (receives ? setup->receive_pdo : 0u) + (transmits ? setup->transmit_pdo : 0u));
}

static inline int cia402_setup_is_done(const struct cia402_setup *setup)
{
    return setup->step >= cia402_setup_steps;
}

/* What is left is read once the drive is enabled. */
static inline int cia402_setup_is_whole(const struct cia402_setup *setup)
{
    return setup->step >= cia402_all_steps;
}

/* The drive has told that it has booted: what it had been set to is gone. */
void cia402_setup_booted(struct cia402_setup *setup);

/* An SDO answer. 0 if it answers nothing that is in flight: the frame is to be rejected. */
int cia402_setup_receive(struct cia402_setup *setup, const uint8_t data[8]);

/* One tick: goes on if the step is done, and appends the request that is due. `nmt_state` is the newest that the
 * drive has told, `is_off` whether it is known to be, or thought, without torque. */
void cia402_setup_step(struct cia402_setup *setup, const struct supervisor *supervisor, const struct hal_tick *tick,
                       uint8_t nmt_state, int is_off, struct tick_output *out);

/* One tick in which the set-up does not go on: a drive that moves by itself is switched off. */
void cia402_setup_hold(struct cia402_setup *setup, const struct supervisor *supervisor, const struct hal_tick *tick,
                       struct tick_output *out);

#ifdef __cplusplus
}
#endif
#endif
