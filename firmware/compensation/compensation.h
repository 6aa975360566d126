/* What the loop does about its dead time: units on the way of the setpoint and on the way of the force, each of
 * which passes through what it gets if it is switched off.
 *
 *     manipulator -> extrapolation -> adaptive inverse -> inverse filter -> limits -> robot
 *     sensor channel -> prediction or force lead -> dissipation -> passivity -> manipulator */
#ifndef FIRMWARE_COMPENSATION_COMPENSATION_H
#define FIRMWARE_COMPENSATION_COMPENSATION_H

#include "../energy_account.h"
#include "adaptive_inverse.h"
#include "extrapolation.h"
#include "force_lead.h"
#include "passivity.h"
#include "prediction.h"

#ifdef __cplusplus
extern "C" {
#endif

struct compensation {
    const struct manipulator *manipulator;
    const struct app_config *config;
    uint8_t is_on; /* one of the units is */
    struct extrapolation extrapolation;
    struct adaptive_inverse inverse;
    struct force_lead lead;
    double velocity_m_per_s; /* of the manipulator one tick ago */
    struct prediction prediction;
    struct passivity passivity;
};

/* What is wrong with the sections of the units; asks for a configuration that has passed config_validate(). */
struct config_error compensation_validate(const struct app_config *config);

/* One of the units is on. */
int compensation_is_on(const struct app_config *config);

/* Keeps pointers to `config` and `manipulator`. */
void compensation_start(struct compensation *compensation, const struct app_config *config,
                        const struct manipulator *manipulator);

/* The manipulator has been put to rest: what came before does not count. */
void compensation_rest_at(struct compensation *compensation, double position_m);

/* Position of the manipulator in, where the robot is to be sent out, in m. */
double compensation_motion(struct compensation *compensation, double position_m);

/* Once a tick, after the setpoint has gone out: the force for the manipulator's step, in N. */
double compensation_force(struct compensation *compensation, const struct operator_command *command,
                          const struct energy_sums *energy, const struct prediction_input *in, int is_running);

#ifdef __cplusplus
}
#endif
#endif
