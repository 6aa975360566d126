/* Force frames to the force that the manipulator step uses. A sample counts when all of its frames have come: frames
 * of two samples are never put together, if they carry the number of their sample.
 *
 * If they carry none, frames that come in their order and within sensor_channel.pairing_window_ms of the first one
 * are one sample. Any other is a suspected torn sample. What this cannot see: a sample of which every frame is
 * missing, a sample that is sent twice, and frames of two samples that come closer together than the window. */
#ifndef FIRMWARE_SENSOR_CHANNEL_H
#define FIRMWARE_SENSOR_CHANNEL_H

#include "sensor_layout.h"
#include "types.h"

#ifdef __cplusplus
extern "C" {
#endif

struct sensor_channel {
    const struct sensor_channel_config *config;
    const struct wrench_config *transformation;
    const struct tare_config *tare;
    const struct sensor_layout_row *layout;
    int64_t stale_after_ns;
    int64_t counter_lasts_ns; /* half a turn of the counter: until then a number means one sample. Without one: the
                                 pairing window, from the first frame on */

    struct wrench wrench; /* newest whole sample: what the robot exerts on the object. In the sensor's axes, or with
                             [wrench] in the robot's frame about the tool's point */
    double force_N;       /* of it, along the axis of the loop; both without the tare */
    int64_t received_ns;  /* when the last of its frames arrived */
    uint8_t saturated;    /* a sample of this tick, or the newest one, was at the end of the sensor's range */
    uint8_t over_limit;   /* the same: was beyond sensor_channel.force_limit_N on any axis */
    uint8_t has_sample;   /* a sample has come in this tick */
    uint8_t has_any;      /* a sample has come since the start */

    struct wrench parts;   /* of the newest sample that has begun to come */
    uint8_t parts_here;    /* a bit for each of its frames; all of them: it is whole. 0: none has ever begun */
    uint8_t counter;       /* its number */
    int64_t begun_ns;      /* when its first frame arrived */
    uint32_t samples;      /* whole ones; wraps around */
    int64_t suspected_ns;  /* without a number: when the newest suspected one came */
    uint32_t torn_samples; /* begun and never whole: rejected. Without a number: suspected */
};

/* Keeps a pointer to `config`. */
void sensor_channel_start(struct sensor_channel *channel, const struct app_config *config);

/* Call before the first frame of a tick. */
void sensor_channel_begin_tick(struct sensor_channel *channel);

/* Takes a checked frame, the layout's `part`. 0 if the frame is to be rejected: it cannot be decoded, or a newer
 * sample has overtaken its own. */
int sensor_channel_receive(struct sensor_channel *channel, int part, const struct hal_frame *frame);

/* No whole sample yet, or the newest is older than sensor_channel.stale_after_ms. */
int sensor_channel_is_stale(const struct sensor_channel *channel, int64_t now_ns);

#ifdef __cplusplus
}
#endif
#endif
