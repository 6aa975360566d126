/* How a force sensor puts a sample into CAN frames: the tables of the layouts in can/berth.dbc. A sample of several
 * frames carries its counter in each of them, or in none. */
#ifndef FIRMWARE_SENSOR_LAYOUT_H
#define FIRMWARE_SENSOR_LAYOUT_H

#include "config.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SENSOR_FRAMES_MAX 3
#define SENSOR_AXES_MAX 3

/* What the robot exerts on the object, in the sensor's axes. */
struct wrench {
    double force_N[SENSOR_AXES_MAX];
    double torque_N_m[SENSOR_AXES_MAX];
    uint8_t saturated; /* the sensor is at the end of its range, on any axis */
};

struct sensor_frame {
    uint32_t id;
    uint8_t counter_byte; /* of a longer counter, that of its lowest bits */
    uint8_t counter_mask; /* 0: there is none */
    /* Puts the frame's signals into their places. 0: one is outside its range, and *wrench is undefined. Of a signal
     * that goes across two frames, the later one adds its share. */
    int (*decode)(const uint8_t data[8], struct wrench *wrench);
};

struct sensor_layout_row {
    uint8_t frame_count;
    uint8_t axis_count;    /* 1: the one force is force_N[0] */
    double force_max_N;    /* end of the range, on either side */
    double torque_max_N_m; /* the same; 0: it tells no torques */
    double force_step_N;   /* of the wire */
    struct sensor_frame frames[SENSOR_FRAMES_MAX];
};

extern const struct sensor_layout_row sensor_layouts[SENSOR_LAYOUT_COUNT];

/* Each frame tells which sample it belongs to. */
static inline int sensor_layout_is_numbered(const struct sensor_layout_row *row)
{
    return row->frames[0].counter_mask != 0;
}

/* Number of a frame's sample, from 0 to the row's counter_mask. */
static inline uint8_t sensor_frame_counter(const struct sensor_frame *row, const uint8_t data[8])
{
    return data[row->counter_byte] & row->counter_mask;
}

#ifdef __cplusplus
}
#endif
#endif
