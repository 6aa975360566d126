/* Configuration of the firmware: plain values, units in the names, checked once, never changed while running.
 * The same names, prefixed by their section, are the keys of a rig file. */
#ifndef FIRMWARE_CONFIG_H
#define FIRMWARE_CONFIG_H

#include <stddef.h>
#include <stdint.h>

#include "arm/arm_config.h"

#ifdef __cplusplus
extern "C" {
#endif

enum integrator { INTEGRATOR_EXACT, INTEGRATOR_SEMI_IMPLICIT_EULER, INTEGRATOR_RK4, INTEGRATOR_COUNT };

/* How the robot is spoken to: frames of berth.dbc, or a CiA 402 drive on CANopen. */
enum robot_profile { ROBOT_PROFILE_BERTH, ROBOT_PROFILE_CIA402, ROBOT_PROFILE_COUNT };

enum operator_interface { OPERATOR_INTERFACE_MOTION, OPERATOR_INTERFACE_FORCE, OPERATOR_INTERFACE_COUNT };

/* Frames of a force sensor's sample, see sensor_layout.h. Byte order as DBC files call it: Intel is little-endian.
 */
enum sensor_layout {
    SENSOR_ONE_FRAME,
    SENSOR_TWO_FRAMES_INTEL,
    SENSOR_TWO_FRAMES_MOTOROLA,
    SENSOR_THREE_FRAMES_INTEL,
    SENSOR_THREE_FRAMES_MOTOROLA,
    SENSOR_TWO_FRAMES_UNNUMBERED,
    SENSOR_TWO_FRAMES_UNNUMBERED_SPLIT,
    SENSOR_LAYOUT_COUNT
};

enum sensor_axis { SENSOR_AXIS_X, SENSOR_AXIS_Y, SENSOR_AXIS_Z, SENSOR_AXIS_COUNT };

/* [loop] */
struct loop_config {
    double rate_Hz;               /* must divide 1e9 ns, as 400 or 250/3 (a period of 12 ms) do */
    double missed_time_budget_ms; /* that missed ticks may take before it is a fault */
    double missed_time_refill_s;  /* in which the whole budget comes back */
};

/* [manipulator]: M x'' + D (x' - v_op) + K (x - x_op) = F_op - F
 * With an arm: what it comes to along the robot's direction, for all that reckons with a manipulator of one degree
 * of freedom; the loop itself steps the arm. */
struct manipulator_config {
    double mass_kg;
    double damping_N_s_per_m;
    double stiffness_N_per_m;
    double initial_position_m;
    double initial_velocity_m_per_s;
    int32_t integrator; /* enum integrator */
    int64_t substeps;   /* integrator steps per period */
    double direction_x; /* with an arm: the robot's, in the arm's world; of any length */
    double direction_y;
    double direction_z;
};

/* [operator]: what an operator command may be, and how old */
struct operator_config {
    int32_t interface; /* enum operator_interface */
    int32_t bus;       /* enum hal_bus: commands and requests are taken from this one alone */
    double position_limit_m;
    double velocity_limit_m_per_s;
    double force_limit_N;
    double stale_after_ms;
};

/* [sensor_channel] */
struct sensor_channel_config {
    int32_t layout;           /* enum sensor_layout */
    int32_t axis;             /* enum sensor_axis: the sensor's axis that the loop moves along */
    double rate_Hz;           /* samples a second; 0: one a tick. In a rig file it is the sensor's, sensor.rate_Hz */
    double force_limit_N;     /* a larger measured force is a fault */
    double pairing_window_ms; /* without a number: the frames of a sample come within it */
    double stale_after_ms;
};

/* [limits]: of the setpoints on the wire. Of an axis that turns: in rad */
struct limits_config {
    double position_min_m;
    double position_max_m;
    double velocity_m_per_s;
    double acceleration_m_per_s2;
};

/* What the robot can show of the tool's pose beside the way along the direction of the loop, in the robot's frame: x
 * is that direction, z what of the world's z is at right angles to it (of its y, where the direction is within 26
 * degrees of z), y completes them. Turns are the components of one rotation vector. */
enum side_axis { SIDE_AXIS_Y, SIDE_AXIS_Z, SIDE_AXIS_RX, SIDE_AXIS_RY, SIDE_AXIS_RZ, SIDE_AXIS_COUNT };

/* [axis.*]: one of them. Lengths in m, of a turn rad. */
struct side_axis_config {
    int32_t enabled;
    double start_tolerance;
    struct limits_config limits;
};

/* [wrench]: all that the sensor measures counts, brought to the tool's point and into the robot's frame. */
struct wrench_config {
    int32_t enabled;     /* else the force along sensor_channel.axis */
    double to_robot[36]; /* row-major: (force, torque) in the robot's frame = to_robot * (force, torque) in frames */
};

/* [robot_channel] */
struct robot_channel_config {
    int32_t profile; /* enum robot_profile */
    double stale_after_ms;
    double unsent_after_ms; /* frames that the bus does not take for longer are a fault */
    double
        setpoint_stale_after_ms; /* age of the newest setpoint that the robot echoes; not finite: it does not echo */
    double start_tolerance_m;    /* largest distance between robot and first setpoint at which the loop gets ready */
    int32_t watch_only;          /* no setpoint is ever sent: the loop does not get ready */
};

/* Sign of the drive's positions, 0x607E. */
enum cia402_polarity { POLARITY_AS_IT_IS, POLARITY_NORMAL, POLARITY_REVERSED, POLARITY_COUNT };

/* [cia402]: the drive, for the profile of that name */
struct cia402_config {
    int64_t node_id;
    int64_t master_node_id; /* ours */
    double counts_per_m;    /* of target position and position actual value */
    double heartbeat_ms;    /* of the drive and of ours: whole numbers */
    double stale_after_ms;  /* age of a heartbeat, either way */
    double sdo_timeout_ms;
    double state_timeout_ms; /* for the drive to boot, and to be enabled */
    int32_t must_watch_loop; /* flag: a drive that can watch neither our heartbeat nor node guarding is refused */
    int64_t homing_method;   /* 0x6098; 0: none */
    double homing_timeout_ms;
    int64_t encoder_counts; /* 0x608F; of these and the next two pairs 0: the drive keeps what it has */
    int64_t encoder_revolutions;
    int64_t gear_motor_revolutions; /* 0x6091 */
    int64_t gear_shaft_revolutions;
    int64_t feed_counts; /* 0x6092 */
    int64_t feed_shaft_revolutions;
    int32_t polarity; /* enum cia402_polarity */
};

/* [inverse_filter]: takes away the amplitude error of a robot that is named by [robot] transfer_* */
struct inverse_filter_config {
    int32_t enabled;
    double robot_frequency_Hz;
    double robot_damping_ratio;
    double bandwidth_Hz; /* of the poles that replace the robot's: well above the band to be corrected */
};

/* [energy]: what the energy account needs to pair a force with the robot's position at the same instant */
struct energy_config {
    double force_age_ms;    /* at use, since it acted. In a rig file it follows from [sensor] */
    double position_age_ms; /* of the robot's feedback at use; 0: one period */
};

/* What the loop knows of the hardware: robot, sensor spring, object, low-pass, in the terms of a rig file, from
 * which it follows. The rest of the file's model (other effects, noise, the bus) is not part of it. */
struct hardware_model {
    double setpoint_to_motion_ms;
    double sample_age_ms; /* of a force sample when it is used */
    double report_age_ms; /* of the position that the robot reports, when it is used */
    double loop_delay_ms; /* by which a slow force comes late: these, lags, and half a period that it is held */
    int32_t holds;        /* the robot jumps to a setpoint; else it moves on straight lines */
    int32_t is_one_sided; /* a tool that meets the surface, else a gripped object */
    int32_t low_pass_order;
    double low_pass_w_rad_per_s;
    double low_pass_damping_ratio;
    double robot_w_rad_per_s; /* of its transfer behaviour; 0: none */
    double robot_damping_ratio;
    double robot_lag_ms;
    double sensor_lag_ms;
    double robot_gain;  /* of the robot's motion over its setpoints */
    double sensor_gain; /* of what the sensor shows over the force */
    double sensor_stiffness_N_per_m;
    double sensor_damping_N_s_per_m;
    double mass_kg;
    double damping_N_s_per_m;
    double stiffness_N_per_m;
    double surface_m;
};

/* [extrapolation]: of the setpoints, over the dead time */
struct extrapolation_config {
    int64_t order;   /* 1 to 3; 0: none */
    double delay_ms; /* 0: what other units leave of all that the loop has */
};

/* [adaptive_inverse]: of the robot's motion */
struct adaptive_inverse_config {
    int32_t enabled;
    double tolerance;      /* of what is told of the robot's delay, as a share: one standard deviation; 0, and ... */
    double gain_tolerance; /* ... of its gain: 0, too: it stays as told */
    double bandwidth_Hz;   /* of the motion that it is fitted to */
    double position_noise_m;
    double memory_s;
    double correction_max_m; /* between what is wanted and the setpoint */
};

/* [force_lead]: of the measured force, by the object's model */
struct force_lead_config {
    int32_t enabled;
    double age_ms;             /* over which it is led; 0: what the motion side leaves */
    double error_bandwidth_Hz; /* up to which the model is corrected; not finite: at once */
};

/* [prediction]: of the force that belongs to the manipulator's present motion */
struct prediction_config {
    int32_t enabled;
    double error_bandwidth_Hz; /* up to which the measured force corrects the model */
    double dead_time_ms;       /* what the model takes for the rig's own; not finite: that */
    double mass_kg;
    double damping_N_s_per_m;
    double stiffness_N_per_m;
};

/* [identification]: of the object and of the dead time, for the prediction */
struct identification_config {
    int32_t enabled;
    double tolerance;        /* of mass, damping, stiffness and dead time, as a share: one standard deviation */
    double noise_N;          /* of the force, and of what no model knows: standard deviation */
    double position_noise_m; /* the same of the robot's reports */
    double memory_s;
};

/* What a passivity controller does about energy that has been made. */
enum passivity_action { PASSIVITY_OFF, PASSIVITY_DAMPING, PASSIVITY_TANK, PASSIVITY_ACTION_COUNT };

/* What the hardware may give back to the manipulator at most. */
enum passivity_reference { PASSIVITY_ZERO, PASSIVITY_MEASURED, PASSIVITY_REFERENCE_COUNT };

/* [passivity] */
struct passivity_config {
    int32_t action;    /* enum passivity_action */
    int32_t reference; /* enum passivity_reference */
    double credit_J;   /* at the start, and at most */
    double horizon_ms; /* over which a deficit is taken away */
    double damping_max_N_s_per_m;
};

/* [dissipation]: a damper against the operator's command */
struct dissipation_config {
    double damping_N_s_per_m;
};

/* [feedback]: how much of the measured force the manipulator feels */
struct feedback_config {
    double gain;   /* 0 to 1 */
    double ramp_s; /* time in which it would rise from 0 to 1, since the loop began to run; 0: at once */
};

/* What the sensor shows with no force on the object: its zero and the tool's weight, in the sensor's axes. It is
 * taken off every sample. In a rig file it follows from [tare] and [tool]. */
struct tare_config {
    int32_t enabled;
    double force_N[3];
    double torque_N_m[3];
};

/* [reflex]: what makes the loop stop by itself */
struct reflex_config {
    double following_error_m; /* between the robot's report and the setpoint that belongs to it; not finite: off */
    double following_error_ms;
    double link_quality; /* least share of ticks with a report of the robot, and with a force sample; 0: off */
    double link_quality_window_s;
    double dead_time_power_W; /* that dead time makes at most; not finite: off */
    double dead_time_power_window_s;
    double growth_J; /* energy of the manipulator that nobody gave it, at most; not finite: off */
};

struct app_config {
    struct loop_config loop;
    struct reflex_config reflex;
    struct feedback_config feedback;
    struct tare_config tare;
    struct manipulator_config manipulator;
    struct arm_config arm; /* ARM_NONE: there is none */
    struct operator_config operator_command;
    struct sensor_channel_config sensor_channel;
    struct robot_channel_config robot_channel;
    struct cia402_config cia402;
    struct limits_config limits;
    struct side_axis_config side_axes[SIDE_AXIS_COUNT]; /* with an arm only */
    struct wrench_config wrench;
    struct inverse_filter_config inverse_filter;
    struct energy_config energy;
    struct hardware_model hardware;
    struct extrapolation_config extrapolation;
    struct adaptive_inverse_config adaptive_inverse;
    struct force_lead_config force_lead;
    struct prediction_config prediction;
    struct identification_config identification;
    struct passivity_config passivity;
    struct dissipation_config dissipation;
};

#define NS_PER_S INT64_C(1000000000)

/* What is wrong with a configuration: the key, as in a rig file, and a sentence. key is NULL if nothing is. */
struct config_error {
    const char *key;
    const char *message;
};

/* Values that suit a 400 Hz loop with a robot of the size in the paper. */
struct app_config config_default(void);

/* Checks every value and their relations. */
struct config_error config_validate(const struct app_config *config);

int64_t config_period_ns(const struct app_config *config);
/* Of the force sensor. */
int64_t config_sample_period_ns(const struct app_config *config);

double config_period_s(const struct app_config *config);

/* The arm leads the measured force by half a period itself; the force lead leaves nothing of it to the arm. */
int config_leads_force(const struct app_config *config);

/* By which a tick's force comes late in the mean, in s: half of the period that it is held, or nothing. */
double config_force_hold_s(const struct app_config *config);

/* The loop's period as object 0x60C2 of CiA 402 wants it: value * 10^index s, whole ms with index -3, as many drives
 * know no other. value is 0 if there is none. */
struct interpolation_period {
    uint8_t value;
    int8_t index;
};
struct interpolation_period config_interpolation_period(const struct app_config *config);
/* The value that goes with this index; 0: none makes the period. */
uint8_t config_interpolation_value(const struct app_config *config, int8_t index);

/* Milliseconds to the nearest nanosecond; the only conversion of configured durations. Non-negative input; INT64_MAX
 * for what is not finite or too long. */
int64_t ns_from_ms(double duration_ms);

#ifdef __cplusplus
}
#endif
#endif
