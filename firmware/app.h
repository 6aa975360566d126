/* The firmware: everything that happens in one tick. Start here. */
#ifndef FIRMWARE_APP_H
#define FIRMWARE_APP_H

#include "compensation/compensation.h"
#include "config.h"
#include "delivery.h"
#include "energy_account.h"
#include "force_feedback.h"
#include "inverse_filter.h"
#include "limits.h"
#include "manipulator.h"
#include "missed_time.h"
#include "operator_command.h"
#include "reception.h"
#include "recorder.h"
#include "reflexes.h"
#include "robot_channel.h"
#include "sensor_channel.h"
#include "side_axes.h"
#include "supervisor.h"
#include "types.h"

#ifdef __cplusplus
extern "C" {
#endif

struct app {
    struct app_config config;
    struct reception reception;
    struct operator_channel operator_channel;
    struct sensor_channel sensor_channel;
    struct robot_channel robot_channel;
    struct supervisor supervisor;
    struct manipulator manipulator;
    struct energy_account energy;
    struct compensation compensation;
    struct force_feedback force_feedback;
    struct inverse_filter inverse_filter;
    struct limits limits;
    struct side_axes side_axes;
    struct missed_time missed_time;
    uint32_t missed_ticks;     /* since the loop was started or reset */
    uint32_t unrecorded_ticks; /* ticks whose record found the ring full */
    uint32_t unsent_frames;    /* frames that found the transmit queue full: an input of the next tick */
    struct refusal refusal;
    struct reflexes reflexes;
    uint32_t sent_frames; /* by the last tick */
    uint8_t heartbeat;
    struct arm_record arm_record;   /* of the newest tick, with an arm */
    struct side_record side_record; /* the same, where the robot has further axes */
    struct recorder recorder;       /* the tick's own record, and all of them as log messages */
};

/* Puts the firmware to its initial state. `config` must have passed config_validate(). The struct must not be
 * moved afterwards: its parts point at its configuration. */
void app_start(struct app *app, const struct app_config *config);

/* One tick: a function of `in` and of what earlier ticks left in `app`, and of nothing else. No heap, no system
 * call, no clock. */
void app_step(struct app *app, const struct tick_input *in, struct tick_output *out);

#ifdef __cplusplus
}
#endif
#endif
