/* Force side: the force that belongs to the manipulator's motion now, where the measured one belongs to a motion
 * that is a dead time old. The object that the rig file tells moves together with the simulated manipulator, without
 * dead time; its twin behind the robot says what the sensor should show, and what the sensor shows beyond that is
 * fed back (a Smith predictor for each measured force; Smith 1957, Li et al. 2026).
 *
 *     F_used = F_model(x now, mean over the coming tick) + Q (F_measured - F_twin)
 *
 * Q: first-order low-pass. Of what is measured beyond the twin, identification explains a part as mass, damping and
 * stiffness of the object; that part acts on the motion now, too, and only the rest is fed back. If the model is
 * right, the loop swings as if it had no dead time, whatever Q. */
#ifndef FIRMWARE_COMPENSATION_PREDICTION_H
#define FIRMWARE_COMPENSATION_PREDICTION_H

#include "../config.h"
#include "../manipulator.h"
#include "../operator_command.h"
#include "dead_time_tracker.h"
#include "hardware_twin.h"
#include "identification.h"

#ifdef __cplusplus
extern "C" {
#endif

struct prediction {
    int32_t enabled;
    struct hardware_twin twin;
    const struct manipulator *manipulator;
    struct identification identification;
    struct dead_time_tracker tracker;
    double period_s;
    double force_max_N;
    double error_share; /* of a new error in what is fed back */
    uint32_t substeps;
    double coupled[2][10]; /* manipulator with the object, over a substep: row-major 2 x 5, state (x, v), input
                              (x_op, v_op, F_op - error); [free or touching] */

    double error_N;          /* measured less twin */
    double fed_back_N;       /* of it */
    double identified_N;     /* what acts beyond the model by what has been identified */
    double velocity_m_per_s; /* of the manipulator one tick ago */
    double force_N;          /* what the loop is to use */
    uint32_t saturated;      /* ticks in which force_max_N acted */
};

/* The dead time fits. */
int prediction_fits(const struct app_config *config);

/* Keeps a pointer to `manipulator`. */
void prediction_start(struct prediction *prediction, const struct app_config *config,
                      const struct manipulator *manipulator);

/* What a tick brings. */
struct prediction_input {
    double measured_N;
    double setpoint_m; /* that goes out to the robot */
    double reported_m; /* where the robot says it is */
};

/* What the loop takes the object and the robot's dead time for: told, and corrected by what has been identified; 0
 * if not enabled. */
struct believed_hardware {
    double mass_kg;
    double damping_N_s_per_m;
    double stiffness_N_per_m;
    double dead_time_ms;
};
struct believed_hardware prediction_belief(const struct prediction *prediction);

/* One tick. Returns the force for the coming step of the manipulator, in N; the measured one if not enabled. */
double prediction_step(struct prediction *prediction, const struct operator_command *command,
                       const struct prediction_input *in);

#ifdef __cplusplus
}
#endif
#endif
