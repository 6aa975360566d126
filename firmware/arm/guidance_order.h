/* What an operator may order an arm to do. */
#ifndef FIRMWARE_ARM_GUIDANCE_ORDER_H
#define FIRMWARE_ARM_GUIDANCE_ORDER_H

#include <stdint.h>

#include "arm_config.h"

#ifdef __cplusplus
extern "C" {
#endif

enum arm_order_kind {
    ARM_ORDER_FOLLOW,     /* the tool along the robot's direction, as the operator's motion says */
    ARM_ORDER_JOINT_RATE, /* until another order for this joint; joints without any stand still */
    ARM_ORDER_JOINT_MOVE,
    ARM_ORDER_LINE, /* the tool, from where it is commanded to be */
    ARM_ORDER_COUNT
};

struct arm_order {
    int32_t kind; /* enum arm_order_kind */
    int32_t joint;
    double rate_rad_per_s; /* JOINT_RATE; of JOINT_MOVE at most: 0, what the joint can */
    double angle_rad;      /* JOINT_MOVE: where to */
    double way_m[3];       /* LINE: in the base's axes */
    double speed_m_per_s;
};

/* "Now limited by" */
enum guidance_limit {
    GUIDANCE_RATE = 1 << 0,
    GUIDANCE_ACCELERATION = 1 << 1,
    GUIDANCE_ANGLE = 1 << 2,
    GUIDANCE_SINGULAR = 1 << 3,
};

#define GUIDANCE_LIMIT_COUNT 4
extern const char *const guidance_limit_names[GUIDANCE_LIMIT_COUNT]; /* by bit number */

#ifdef __cplusplus
}
#endif
#endif
