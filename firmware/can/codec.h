/* Numbers to and from signals of berth.dbc. The generated encoder truncates and wraps silently out of range
 * (2000 N became -1276.8 N in 16 bits), so values are saturated and rounded here, before it sees them. */
#ifndef FIRMWARE_CAN_CODEC_H
#define FIRMWARE_CAN_CODEC_H

#include <stdbool.h>

#include "berth_can.h"

/* Physical ranges of the signals, as in berth.dbc (a test compares them). */
#define CAN_POSITION_MAX_m 5.4
#define CAN_FORCE_MAX_N 54000.0
#define CAN_WRENCH2I_FORCE_MAX_N 327.0
#define CAN_WRENCH2M_FORCE_MAX_N 655.0
#define CAN_WRENCH2U_FORCE_MAX_N 327.0
#define CAN_WRENCH2S_FORCE_MAX_N 655.0
#define CAN_WRENCH3I_FORCE_MAX_N 838.0
#define CAN_WRENCH3M_FORCE_MAX_N 1340.0
#define CAN_WRENCH2I_TORQUE_MAX_N_m 32.0
#define CAN_WRENCH2M_TORQUE_MAX_N_m 32.0
#define CAN_WRENCH2U_TORQUE_MAX_N_m 32.0
#define CAN_WRENCH2S_TORQUE_MAX_N_m 16.0
#define CAN_WRENCH3I_TORQUE_MAX_N_m 83.0
#define CAN_WRENCH3M_TORQUE_MAX_N_m 134.0
#define CAN_OPERATOR_POSITION_MAX_m 2.1
#define CAN_OPERATOR_VELOCITY_MAX_m_per_s 8.3

/* Limits `value` to +-`max` and sets *saturated if that changed it; a NaN becomes 0 and counts as saturated. */
static inline double codec_saturate(double value, double max, bool *saturated)
{
    if (value >= -max && value <= max) {
        return value;
    }
    *saturated = true;
    return value > max ? max : value < -max ? -max : 0.0;
}

/* Adds half a step away from zero, so that the encoder's truncation rounds to nearest. */
static inline double codec_round(double value, double step)
{
    return value < 0.0 ? value - 0.5 * step : value + 0.5 * step;
}

#endif
