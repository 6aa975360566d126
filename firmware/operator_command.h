/* Operator frames to a validated command for the manipulator. */
#ifndef FIRMWARE_OPERATOR_COMMAND_H
#define FIRMWARE_OPERATOR_COMMAND_H

#include "arm/guidance_order.h"
#include "config.h"
#include "reception.h"

#ifdef __cplusplus
extern "C" {
#endif

enum operator_request { OPERATOR_NONE, OPERATOR_HOLD, OPERATOR_RUN, OPERATOR_RESET, OPERATOR_REQUEST_COUNT };

/* What the operator wants of the manipulator. Either the motion or the force is used, see [operator] interface;
 * the other is 0. Base frame of the manipulator, along its one degree of freedom. */
struct operator_command {
    double position_m;
    double velocity_m_per_s;
    double force_N;
    uint8_t request; /* enum operator_request */
};

struct operator_channel {
    const struct operator_config *config;
    const struct arm_config *arm;
    enum received_message message;   /* of the two that this configuration listens to */
    struct operator_command command; /* the newest valid one */
};

/* The command of a manipulator that rests where it starts. Keeps a pointer to `config`. */
void operator_channel_start(struct operator_channel *channel, const struct app_config *config);

/* Takes a checked frame. 0 if a signal is out of range: the frame is to be rejected. */
int operator_channel_receive(struct operator_channel *channel, enum received_message message,
                             const struct hal_frame *frame);

/* The same of an order for the arm, which comes out in `order`. */
int operator_channel_receive_order(const struct operator_channel *channel, enum received_message message,
                                   const struct hal_frame *frame, struct arm_order *order);

/* Which of the two operator messages this configuration listens to. */
enum received_message operator_message(const struct operator_config *config);

#ifdef __cplusplus
}
#endif
#endif
