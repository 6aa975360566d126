#include "loop.h"

/* Takes what has arrived, the sensor's bus first: a flood on the robot's bus must not cost the force sample. */
static enum hal_status read_inputs(struct hal *hal, struct tick_input *in)
{
    static const enum hal_bus order[] = {HAL_BUS_SENSOR, HAL_BUS_ROBOT};
    static const uint32_t room_up_to[] = {TICK_SENSOR_FRAMES_MAX, TICK_FRAMES_IN_MAX};
    in->frame_count = 0;
    for (uint32_t i = 0; i < HAL_BUS_COUNT; i++) {
        while (in->frame_count < room_up_to[i]) {
            const enum hal_status status = hal_can_receive(hal, order[i], &in->frames[in->frame_count]);
            if (status == HAL_EMPTY) {
                break;
            }
            if (status != HAL_OK) {
                return status;
            }
            in->frame_count++;
        }
    }
    const enum hal_status status = hal_gpio_get(hal, HAL_LINE_EMERGENCY_STOP, &in->emergency_stop);
    return status != HAL_OK ? status : hal_gpio_get(hal, HAL_LINE_ENABLE, &in->enable);
}

static enum hal_status write_outputs(struct hal *hal, struct app *app, const struct tick_output *out)
{
    for (uint32_t i = 0; i < out->frame_count; i++) {
        const enum hal_status status = hal_can_send(hal, &out->frames[i]);
        if (status == HAL_NO_BUFFER) {
            app->unsent_frames++;
        } else if (status != HAL_OK) {
            return status;
        }
    }
    const enum hal_status status = hal_gpio_set(hal, HAL_LINE_HEARTBEAT, out->heartbeat);
    return status != HAL_OK ? status : hal_gpio_set(hal, HAL_LINE_FAULT, out->fault);
}

static enum hal_status record(struct hal *hal, struct app *app)
{
    const enum hal_status status = hal_record(hal, app->recorder.bytes, app->recorder.size_bytes);
    if (status == HAL_NO_BUFFER) {
        app->unrecorded_ticks++;
        return HAL_OK;
    }
    return status;
}

enum hal_status loop_tick(struct hal *hal, struct app *app)
{
    struct tick_input in;
    struct tick_output out;
    in.unsent_frames = app->unsent_frames;
    enum hal_status status = hal_wait_tick(hal, &in.tick);
    if (status == HAL_OK) {
        status = read_inputs(hal, &in);
    }
    if (status != HAL_OK) {
        return status;
    }
    app_step(app, &in, &out);
    status = write_outputs(hal, app, &out);
    return status != HAL_OK ? status : record(hal, app);
}

enum hal_status loop_run(struct hal *hal, struct app *app)
{
    enum hal_status status = HAL_OK;
    while (status == HAL_OK && app->supervisor.state != SUPERVISOR_STOPPED) {
        status = loop_tick(hal, app);
    }
    return status == HAL_OK ? HAL_END : status;
}
