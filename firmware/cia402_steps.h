/* The set-up of a CiA 402 drive as one const table of steps, and the ways through it: what a drive lacks or refuses
 * leads past some steps and to others. Sources: CiA 301 (services, 0x1xxx), CiA 402 (0x6xxx). */
#ifndef FIRMWARE_CIA402_STEPS_H
#define FIRMWARE_CIA402_STEPS_H

#include "config.h"

#ifdef __cplusplus
extern "C" {
#endif

enum step_kind {
    STEP_SWITCH_OFF, /* wait until the drive is without torque; one that says nothing is not waited for */
    STEP_BOOT,       /* NMT reset communication, then its boot-up message; again and again, it may be switched off */
    STEP_WRITE,
    STEP_GUARD,  /* write; from then on the drive is guarded */
    STEP_EXPECT, /* read until value & mask is what it has to be */
    STEP_MATCH,  /* read an entry of a fixed PDO mapping; if it does not fit, the next PDO is looked at */
    STEP_PERIOD, /* write a part of the period, as the loop has it */
    STEP_READ_PERIOD_INDEX,
    STEP_PERIOD_IN_INDEX, /* write the value that goes with the drive's own index */
    STEP_READ_PERIOD_VALUE,
    STEP_MAY_MOVE, /* wait until the enable line permits the drive to move by itself */
    STEP_HOME,     /* read the statusword until the homing has ended */
    STEP_OPERATE   /* NMT start, then its heartbeat says operational */
};

/* What an SDO abort of a step means. */
enum step_refusal {
    REFUSAL_IS_TROUBLE,
    MAY_BE_MISSING, /* a drive without this object goes on; any other abort is trouble */
    MAY_BE_REFUSED, /* any abort: it goes on */
    MUST_WATCH      /* a drive without it watches nobody: refused, unless the rig file lets it be */
};

/* One bit each: what the rig file wants, or the drive has shown. */
enum setup_way {
    WAY_GUARDED = 1,        /* no heartbeat: node guarding */
    WAY_OWN_PERIOD = 2,     /* refuses the period as it is offered first */
    WAY_FIXED_RECEIVE = 4,  /* the mapping of its receive PDOs cannot be written */
    WAY_FIXED_TRANSMIT = 8, /* of its transmit PDOs */
    WAY_LATE_MODE = 16,     /* shows its mode of operation only when it is enabled */
    WAY_HOMING = 32,
    WAY_ENCODER = 64,
    WAY_GEAR = 128,
    WAY_FEED = 256,
    WAY_POLARITY = 512
};

struct setup_step {
    uint8_t kind;    /* enum step_kind */
    uint8_t refusal; /* enum step_refusal */
    uint16_t index;
    uint8_t subindex;
    uint8_t length; /* bytes of the object */
    uint32_t value;
    uint32_t mask;                                       /* of a value that is read */
    uint32_t (*configured)(const struct app_config *of); /* added to value; NULL: nothing */
    uint16_t only_with;                                  /* ways; 0: always */
    uint16_t not_with;
    uint16_t reveals; /* the way that a permitted refusal, or a value that does not come, leads to; 0: none */
};

extern const struct setup_step cia402_steps[];

/* Their number before the drive is enabled, and in all: what is left is read when it is. */
extern const uint32_t cia402_setup_steps;
extern const uint32_t cia402_all_steps;

static inline int cia402_step_is_sdo(const struct setup_step *step)
{
    return step->index != 0;
}

static inline int cia402_step_is_read(const struct setup_step *step)
{
    return step->kind == STEP_EXPECT || step->kind == STEP_MATCH || step->kind == STEP_READ_PERIOD_INDEX ||
           step->kind == STEP_READ_PERIOD_VALUE || step->kind == STEP_HOME;
}

/* Index and subindex of the object that a step writes or reads, as 0xIIIISS; 0: none. */
uint32_t cia402_setup_object(uint32_t step);

/* The ways that a rig file chooses. */
uint16_t cia402_configured_ways(const struct app_config *config);

#ifdef __cplusplus
}
#endif
#endif
