/* The bare loop: wait, read, step, write, record. */
#ifndef FIRMWARE_LOOP_H
#define FIRMWARE_LOOP_H

#include "app.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Runs ticks until the HAL ends the run or the supervisor has stopped. HAL_END, or the error that ended it. */
enum hal_status loop_run(struct hal *hal, struct app *app);

/* One tick of it. HAL_OK, HAL_END or an error. */
enum hal_status loop_tick(struct hal *hal, struct app *app);

#ifdef __cplusplus
}
#endif
#endif
