/* Where the loop's energy comes from and where it goes, booked every tick. Passive hardware and a passive
 * manipulator can only lose energy; what grows has been made in between, by the time that passes from setpoint to
 * motion and from force to use, or by the integrator. */
#ifndef FIRMWARE_ENERGY_ACCOUNT_H
#define FIRMWARE_ENERGY_ACCOUNT_H

#include "config.h"
#include "manipulator.h"
#include "operator_command.h"
#include "past.h"

#ifdef __cplusplus
extern "C" {
#endif

/* How much older a force than a position may be, in ticks, for the two to be paired. */
#define ENERGY_LAG_TICKS_MAX 254

/* In J, since the loop last began to run. Two balances hold:
 *     stored - stored at the start = operator + integrator - dissipated - simulated_port
 *     measured_port = simulated_port + dead_time + compensation
 * What is on its way through the robot counts under dead_time, too: a swing about what is really made. */
struct energy_sums {
    double stored_J;         /* kinetic, and in the manipulator's spring; no sum, but what is there now */
    double operator_J;       /* from the operator's motion and force; of an arm: from servos, wheels and thrusters,
                                less what its dampers take */
    double dissipated_J;     /* by the manipulator's damping; of an arm: counted there */
    double integrator_J;     /* made by the step: end of the step against the exact solution from the same state */
    double simulated_port_J; /* the manipulator gave: the force that acts over the tick times the way made in it */
    double measured_port_J;  /* the hardware took: measured force times the robot's way, both of the same instant */
    double dead_time_J;      /* made between the ports ... */
    double compensation_J;   /* ... and what compensation made of it: negative, it took. On the way of the force, and
                                the measured force's work on the way by which the setpoint is displaced */
};

/* What is measured along one axis; m and N, or rad and N m. */
struct energy_port {
    struct past kept;    /* of the fresher of position and force */
    double paired_force; /* one tick ago, brought to the same instant */
    double paired_position;
};

#define ENERGY_PORTS_MAX (1 + SIDE_AXIS_COUNT)

/* Force and robot's position on the robot's further axes: N and m, or N m and rad. */
struct energy_sides {
    double force[SIDE_AXIS_COUNT];
    double position[SIDE_AXIS_COUNT];
};

struct energy_account {
    struct energy_sums sums;
    const struct manipulator *manipulator;
    uint8_t is_open;      /* a step has been announced */
    uint8_t is_measuring; /* force and position are near enough in age to be paired */
    uint8_t is_filled;    /* `kept` */

    double position_m; /* of the manipulator at the announced step's begin ... */
    double velocity_m_per_s;
    struct operator_command command; /* ... and what was held during it */
    double force_N;
    double measured_N;  /* the force that it was made of */
    double displaced_m; /* where the robot was sent, less the manipulator's position */

    double lag_ticks; /* force's age less the position's; negative: the position is older */
    struct energy_port ports[ENERGY_PORTS_MAX]; /* that of the loop's axis, then those of the robot's further axes */
    uint32_t port_count;
    struct energy_sides measured_sides;
    double side_begin[SIDE_AXIS_COUNT]; /* pose at the announced step's begin, m or rad */

    /* Symmetric 4 x 4: e' loss e is what is dissipated in a tick, in J, with e = (x - x_op, v, F_op - F, v_op) at
     * its begin, in m, m/s, N. */
    double loss[16];
};

/* Keeps a pointer to `manipulator`, which has been started. */
void energy_account_start(struct energy_account *account, const struct app_config *config,
                          const struct manipulator *manipulator);

/* Once a tick, before the manipulator's step: books the step that has gone by, if there was one, and what the
 * command now, the measured force (what the robot exerts on the object) and the way by which the setpoint that goes
 * out now is displaced from the manipulator change. */
void energy_account_book(struct energy_account *account, const struct operator_command *command, double measured_N,
                         double robot_position_m, double displaced_m, int is_running);

/* Before that, where the robot has further axes: what is measured there. */
void energy_account_sides(struct energy_account *account, const struct energy_sides *sides);

/* After it: the step that is to come, if `is_running`, with this command and force. */
void energy_account_announce(struct energy_account *account, const struct operator_command *command, double force_N,
                             double measured_N, int is_running);

#ifdef __cplusplus
}
#endif
#endif
