/* Force frames to the force that the manipulator step uses. */
#ifndef FIRMWARE_SENSOR_CHANNEL_H
#define FIRMWARE_SENSOR_CHANNEL_H

#include "config.h"
#include "reception.h"

#ifdef __cplusplus
extern "C" {
#endif

struct sensor_channel {
    const struct sensor_channel_config *config;
    double force_N;      /* newest sample: what the robot exerts on the object */
    int64_t received_ns; /* when it arrived */
    uint8_t saturated;   /* a sample of this tick, or the newest one, was at the end of the sensor's range */
    uint8_t over_limit;  /* the same: was beyond sensor_channel.force_limit_N */
    uint8_t has_sample;  /* a sample has come in this tick */
};

/* Keeps a pointer to `config`. */
void sensor_channel_start(struct sensor_channel *channel, const struct app_config *config);

/* Call before the first frame of a tick. */
void sensor_channel_begin_tick(struct sensor_channel *channel);

/* Takes a checked frame. 0 if it cannot be decoded. */
int sensor_channel_receive(struct sensor_channel *channel, const struct hal_frame *frame);

#ifdef __cplusplus
}
#endif
#endif
