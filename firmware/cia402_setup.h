/* Sets a CiA 402 drive up for cyclic synchronous position, step by step from one const table: NMT commands, and
 * objects written and read by expedited SDO. One step at a time, at most one request in flight, every wait counted
 * in ticks. Sources: CiA 301 (services, 0x1xxx), CiA 402 (0x6xxx). */
#ifndef FIRMWARE_CIA402_SETUP_H
#define FIRMWARE_CIA402_SETUP_H

#include "config.h"
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
    SETUP_UNWATCHED       /* no object 0x1016: it would not stop when the loop dies */
};

struct cia402_setup {
    const struct app_config *config;
    uint32_t step;            /* number of the step; cia402_setup_steps: done */
    uint32_t waited_ticks;    /* in this step */
    uint32_t in_flight_ticks; /* since its request was sent; 0: it has not been */
    uint32_t sdo_timeout_ticks;
    uint32_t state_timeout_ticks;
    uint8_t attempts;          /* of this step's request, that have got no answer */
    uint8_t has_answer;        /* an SDO answer to the request in flight */
    uint8_t has_booted;        /* since the step began */
    uint8_t trouble;           /* enum cia402_setup_trouble; the set-up stands still */
    uint8_t is_strange;        /* an answer to this step that is none of the standard */
    uint8_t segment;           /* enum segment_state: an answer that comes in segments */
    uint8_t period_is_refused; /* as it was offered first */
    int8_t period_index;       /* the drive's own, read back */
    uint8_t period_value;      /* the drive's own, read back; 0: not read */
    uint32_t answer_value;
    uint32_t abort_code;
};

extern const uint32_t cia402_setup_steps;

/* Index and subindex of the object that a step writes or reads, as 0xIIIISS; 0: none. */
uint32_t cia402_setup_object(uint32_t step);

void cia402_setup_start(struct cia402_setup *setup, const struct app_config *config);

/* From the first step on, with all that went wrong forgotten. */
void cia402_setup_restart(struct cia402_setup *setup);

static inline int cia402_setup_is_done(const struct cia402_setup *setup)
{
    return setup->step >= cia402_setup_steps;
}

/* The drive has told that it has booted: what it had been set to is gone. */
void cia402_setup_booted(struct cia402_setup *setup);

/* An SDO answer. 0 if it answers nothing that is in flight: the frame is to be rejected. */
int cia402_setup_receive(struct cia402_setup *setup, const uint8_t data[8]);

/* One tick: goes on if the step is done, and appends the request that is due. `nmt_state` is the newest that the
 * drive has told, `is_off` whether it is known to be, or thought, without torque. */
void cia402_setup_step(struct cia402_setup *setup, const struct supervisor *supervisor, const struct hal_tick *tick,
                       uint8_t nmt_state, int is_off, struct tick_output *out);

#ifdef __cplusplus
}
#endif
#endif
