/* A rig: everything that one run depends on. Members carry the names of the keys in a rig file, unit included;
 * the firmware's part is its own configuration struct. Purely values: copying a rig is always safe. */
#ifndef HAL_RIG_RIG_H
#define HAL_RIG_RIG_H

#include <array>
#include <bitset>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "../../firmware/arm/guidance_order.h"
#include "../../firmware/config.h"
#include "cantilever.h"

namespace berth
{

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double unlimited = std::numeric_limits<double>::infinity();

enum class interpolation : std::int32_t { linear, hold };
enum class robot_clock : std::int32_t { locked, free };
enum class object_kind : std::int32_t { gripped, contact, beam, none };
enum class solver_kind : std::int32_t { fast, cvode };
enum class profile_kind : std::int32_t { rest, step, ramp, minimum_jerk, chirp, multisine, triangle, pulses, file };

/* [run] */
struct run_rig {
    double duration_s = 60.0;
    double release_s = 0.1; /* the operator requests to run from here on; until then the robot is held */
    std::int64_t seed = 1;
    std::string lateness_file; /* histogram of how late the loop wakes; empty: never */
    double emergency_stop_s = never;
    double enable_off_s = never;
    double grip_close_s =
        0.0; /* the gripper closes on the object, which rests until then; 0: gripped from the start */
    double grip_release_s = never; /* the object is let go, for good */
    double dead_time_jump_s = never;
    double dead_time_jump_ms = 0.0; /* by which the robot's dead time is longer from then on */
};

/* [profile]: what the operator station commands, counted from the release */
struct profile_rig {
    profile_kind kind = profile_kind::rest;
    double offset_m = 0.0;    /* motion interface: the position about which the profile moves */
    double amplitude_m = 0.0; /* used by the motion interface */
    double amplitude_N = 0.0; /* used by the force interface */
    double start_s = 0.0;
    double duration_s = 1.0;
    double frequency_start_Hz = 0.1;
    double frequency_end_Hz = 5.0;
    std::string file;
    std::string column;
    double scale = 1.0;
};

/* [robot] */
struct robot_rig {
    double dead_time_ms = 17.5; /* command to motion, time on the bus included; see command_to_motion_ns() */
    berth::interpolation interpolation = berth::interpolation::linear;
    double transfer_frequency_Hz = unlimited; /* G_R = w^2 / (s^2 + 2 z w s + w^2); unlimited: none */
    double transfer_damping_ratio = 0.7;
    double velocity_limit_m_per_s = unlimited;
    double acceleration_limit_m_per_s2 = unlimited;
    robot_clock clock = robot_clock::locked;
    double clock_phase_ms = 0.0;
    double clock_drift_ppm = 0.0;
    double jitter_ms = 0.0;        /* largest shift of a setpoint's instant, uniform, either way */
    double feedback_noise_m = 0.0; /* of the position that it reports: standard deviation, white */
};

/* [sensor] */
struct sensor_rig {
    double stiffness_N_per_m = 2e7; /* k_S */
    double damping_ratio = 0.05;    /* zeta_S: d_S = 2 zeta_S sqrt(k_S m) */
    std::int64_t low_pass_order = 2;
    double low_pass_frequency_Hz = 20.0;
    double low_pass_damping_ratio = 0.7;
    double delay_ms = 2.5; /* T_S: sample to arrival, time on the bus included */
    double sample_phase_ms = 0.0;
    double rate_Hz = 0.0; /* samples a second; 0: one a tick */
    double bias_N = 0.0;
    double noise_N = 0.0; /* standard deviation, white, one value a sample */
    double resolution_N = 0.0;
    double saturation_N = unlimited;
    double loss_probability = 0.0;  /* a sample that is never sent */
    double stale_probability = 0.0; /* a frame that is sent again instead of a new one */
};

/* [axis.*]: the hardware on one of the robot's axes beside that of the loop; what is not said is as there. m, N, kg,
 * or where it turns rad, N m, kg m2. */
struct side_axis_rig {
    double dead_time_ms = 0.0;
    double sensor_stiffness = 0.0;
    double sensor_damping_ratio = 0.05;
    double mass = 0.0;
    double stiffness = 0.0;
    double damping = 0.0;
};

/* [wrench] */
struct wrench_rig {
    bool enabled = false;
    std::array<double, 3> angles_rad{}; /* roll, pitch, yaw */
    std::array<double, 3> origin_m{};
    double torque_noise_N_m = 0.0; /* standard deviation; that of forces is sensor.noise_N */
    std::array<double, 36> crosstalk{1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0,
                                     0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1}; /* row-major */
};

/* A further mode of a beam, by what its first one has: an object that is heavier or stiffer is so in all modes. */
struct mode_shares {
    double mass;
    double damping;
    double stiffness;
};

/* [tare]: what the sensor shows with nothing on it, in its own axes */
struct tare_rig {
    bool enabled = true; /* zero and weight are taken off every sample */
    std::array<double, 3> force_N{};
    std::array<double, 3> torque_N_m{};
};

/* [tool]: what hangs on the sensor, and weighs */
struct tool_rig {
    double mass_kg = 0.0;
    std::array<double, 3> centre_m{};                       /* of mass, in the sensor's axes */
    std::array<double, 3> gravity_m_per_s2{0, 0, -9.80665}; /* the same */
};

/* [object] */
struct object_rig {
    object_kind kind = object_kind::gripped;
    double mass_kg = 100.0; /* gripped object, a beam's first mode, or the tool that meets the surface */
    double stiffness_N_per_m = 0.0;
    double damping_N_s_per_m = 0.0;
    double surface_position_m = 0.0; /* contact: elastic material beyond this position */
    cantilever beam;                 /* beam: a gripped object with several modes */
    std::int64_t modes = 3;

    /* What follows from `beam`, mass, damping and stiffness above included, and of which beam it is. */
    std::array<mode_shares, beam_modes_max - 1> further_modes{};
    std::int64_t further_mode_count = 0;
    cantilever followed_beam;
    std::int64_t followed_modes = 0;
};

/* [bus]: of both buses */
struct bus_rig {
    double bit_rate_bit_per_s = 1e6;
    bool ideal = false; /* frames take no time; for dead times below a frame */
    double loss_probability = 0.0;
    double burst_probability = 0.0; /* a burst of losses starts with this frame */
    double burst_length_frames = 1.0;
    double error_probability = 0.0; /* a frame is destroyed, reported and sent again */
};

/* [solver] */
struct solver_rig {
    solver_kind kind = solver_kind::fast;
    double relative_tolerance = 1e-12;
    double absolute_tolerance_m = 1e-18; /* the other states in proportion */
    double contact_step_us = 25.0;       /* fast solver, contact only */
};

/* [target]: how the loop is wired to real buses and lines; a simulated rig does not ask. Empty line names are not
 * wired. */
struct target_rig {
    std::string robot_interface = "can0";
    std::string sensor_interface = "can1";
    std::string gpio_chip;
    std::string emergency_stop_line = "EMERGENCY_STOP";
    bool emergency_stop_active_low = true;
    std::string enable_line = "ENABLE";
    bool enable_active_low = false;
    std::string heartbeat_line = "HEARTBEAT";
    std::string tick_line = "TICK";
    std::string fault_line = "FAULT";
    std::int64_t cpu = -1;
    std::int64_t priority = 80;
    std::string watchdog_device;
    std::string log_path;
};

/* `mass_kg = { value = 100, tolerance = 0.05 }`: the value is known to 5 %. */
struct tolerance {
    std::string key;
    double share;
};

/* [signals]: where a record of other people's keeps a signal. `force_N = { column = "vir_V", scale = 35.15 }` */
struct signal_source {
    std::string signal; /* as in a record of ours, unit included */
    std::string column;
    double scale = 1.0;
    double offset = 0.0;
};

/* What a record can hold, as columns of a CSV file; `segment` tells parts apart that do not belong together in time.
 */
constexpr std::array<std::string_view, 8> signal_names = {"t_s",
                                                          "operator_force_N",
                                                          "operator_position_m",
                                                          "operator_velocity_m_per_s",
                                                          "command_position_m",
                                                          "robot_position_m",
                                                          "force_N",
                                                          "segment"};

/* Of the operator to an arm, counted from the release. */
struct operator_order {
    double at_s;
    arm_order order;
};

constexpr std::size_t effect_values_max = 64;
constexpr std::size_t rig_keys_max = 320;

/* All of them off, for what is to go on however it moves. */
inline reflex_config without_reflexes(reflex_config reflex)
{
    constexpr double off = std::numeric_limits<double>::infinity();
    reflex.following_error_m = reflex.dead_time_power_W = reflex.growth_J = off;
    reflex.link_quality = 0.0;
    return reflex;
}

struct rig {
    std::string name;
    std::string description;
    app_config firmware = config_default();
    std::bitset<rig_keys_max>
        given;                 /* by place in rig_keys(): stated by file, base, preset or override, see given.h */
    bool is_rate_given = true; /* by file, preset or override; else loop.rate_Hz has its default value */
    std::string arm;           /* manipulator.arm, until it has been read ... */
    std::string arm_text;      /* ... and then the arm as [manipulator.arm] of a rig file; empty: none */
    run_rig run;
    profile_rig profile;
    robot_rig robot;
    sensor_rig sensor;
    std::array<side_axis_rig, SIDE_AXIS_COUNT> side_axes;
    wrench_rig wrench;
    tare_rig tare;
    tool_rig tool;
    object_rig object;
    bus_rig bus;
    solver_rig solver;
    target_rig target;

    /* Parameters of the effects that have no member of their own above; 0: the effect is not there. Which is which
     * stands in the key table. */
    std::array<double, effect_values_max> effect_values{};

    std::vector<operator_order> orders; /* by rising time */
    std::vector<tolerance> tolerances;
    std::vector<signal_source> signals;

    /* How far the value of a key may be off, as a share of it; nothing: not told. */
    std::optional<double> tolerance_of(std::string_view key) const;

    /* d_S in N s/m. */
    double sensor_damping_N_s_per_m() const;
    /* The sensor samples at other places of every period. Its rate must have been checked. */
    bool has_wandering_samples() const
    {
        return config_period_ns(&firmware) % config_sample_period_ns(&firmware) != 0;
    }
    /* Of the newest force sample at a tick, since it was taken; the mean where samples wander. */
    std::int64_t sample_age_ns() const;
    /* By which the sensor's low-pass holds up slow forces. */
    double sensor_low_pass_delay_s() const;
    bool has_side_axes() const;
    bool has_transfer_behaviour() const { return robot.transfer_frequency_Hz != unlimited; }
};

/* The rig as if the loop's axis were this one of the others (enum side_axis): its dead time, sensor and object. The
 * effects of the library and the inverse filter stay with the loop's axis. */
rig rig_along(const rig &whole, std::size_t axis);

/* There is a robot and no object: the sensor feels nothing. */
inline bool touches_nothing(const rig &rig)
{
    return rig.object.kind == object_kind::none;
}

/* When the gripper closes on the object. */
inline double grip_closes_s(const rig &rig)
{
    return touches_nothing(rig) ? never : rig.run.grip_close_s;
}

/* When an event of the run happens that may be never. */
std::int64_t event_ns(double time_s);

/* What is wrong with a rig: the key and a sentence. */
struct rig_error {
    std::string key;
    std::string message;
    std::size_t order = 0; /* which of [[orders]], from 1 on; 0: none of them */
};

/* Checks ranges and relations of all values, the firmware's included; fills in what the firmware has to know of
 * the robot. Nothing: the rig is fine. */
std::optional<rig_error> complete_and_check(rig &rig);

/* How long a setpoint waits until it acts: a synchronous one of a CiA 402 drive for the SYNC of the next tick. */
std::int64_t sync_wait_ns(const rig &rig);

/* T_R: command to motion, robot.dead_time_ms and that wait. */
std::int64_t command_to_motion_ns(const rig &rig);

/* A robot that moves in a straight line to a setpoint must know it a period ahead; else a setpoint's time on the
 * bus. */
std::int64_t least_dead_time_ns(const rig &rig);

/* On the robot's bus in each tick: feedback, operator command, setpoint; in this order. A CiA 402 drive: and SYNC.
 */
std::int64_t robot_frames_a_tick(const rig &rig);

/* Time that a frame of `data_bytes` takes on the bus, in ns: the longest that bit stuffing allows, so that a
 * dead time with the bus in it never turns out longer than stated. */
std::int64_t frame_time_ns(const bus_rig &bus, int data_bytes);

} // namespace berth

#endif
