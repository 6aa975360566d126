#include "key_table.h"

#include <algorithm>
#include <type_traits>

namespace berth
{

namespace
{

enum class range { any, positive, not_negative, fraction, positive_or_inf, not_negative_or_inf };

template <typename T>
constexpr key_type type_of()
{
    if constexpr (std::is_same_v<T, double>) {
        return key_type::number;
    } else if constexpr (std::is_same_v<T, std::int64_t>) {
        return key_type::integer;
    } else if constexpr (std::is_same_v<T, bool>) {
        return key_type::boolean;
    } else if constexpr (std::is_same_v<T, std::string>) {
        return key_type::text;
    } else {
        return key_type::choice;
    }
}

template <typename T>
rig_key make_key(std::string_view path, void *(*member)(rig &), range range, std::string_view meaning,
                 std::vector<std::string_view> choices = {})
{
    rig_key key{path,  type_of<T>(), member, std::is_same_v<T, bool>, -unlimited, unlimited, true,
                false, {},           meaning};
    key.choices = std::move(choices);
    key.low = range == range::any ? -unlimited : 0.0;
    key.low_is_allowed = range != range::positive && range != range::positive_or_inf;
    key.high = range == range::fraction ? 1.0 : unlimited;
    key.infinity_is_allowed = range == range::positive_or_inf || range == range::not_negative_or_inf;
    return key;
}

/* A firmware flag is an int32_t without choices. */
rig_key make_flag(std::string_view path, void *(*member)(rig &), std::string_view meaning)
{
    rig_key key = make_key<bool>(path, member, range::any, meaning);
    key.is_bool = false;
    return key;
}

rig_key up_to(double most, rig_key key)
{
    key.most = most;
    return key;
}

rig_key from(double least, rig_key key)
{
    key.least = least;
    return key;
}

#define KEY(path, member, ...)                                                                                      \
    make_key<std::remove_reference_t<decltype(rig::member)>>(                                                       \
        path, [](rig &of) -> void * { return &of.member; }, __VA_ARGS__)
#define FLAG(path, member, meaning)                                                                                 \
    make_flag(                                                                                                      \
        path, [](rig &of) -> void * { return &of.member; }, meaning)

} // namespace

static std::vector<rig_key> make_own_keys()
{
    using r = range;
    return {
        KEY("run.duration_s", run.duration_s, r::positive, "length of the run"),
        KEY("run.release_s", run.release_s, r::not_negative, "the operator requests to run from here on"),
        KEY("run.seed", run.seed, r::not_negative, "seed of every random draw"),
        KEY("run.lateness_file", run.lateness_file, r::any,
            "how late the loop wakes: JSON of cyclictest with a histogram; empty: never"),
        KEY("run.emergency_stop_s", run.emergency_stop_s, r::not_negative_or_inf,
            "when the emergency stop is pressed; inf: never"),
        KEY("run.enable_off_s", run.enable_off_s, r::not_negative_or_inf, "when enable is taken away; inf: never"),
        KEY("run.grip_close_s", run.grip_close_s, r::not_negative,
            "when the gripper closes on the object, where both are; 0: gripped from the start"),
        KEY("run.grip_release_s", run.grip_release_s, r::not_negative_or_inf,
            "when the gripped object is let go, for good; inf: never"),
        KEY("run.dead_time_jump_s", run.dead_time_jump_s, r::not_negative_or_inf,
            "when the robot's dead time changes; inf: never"),
        KEY("run.dead_time_jump_ms", run.dead_time_jump_ms, r::any,
            "by how much the dead time is longer from then on"),

        from(1, up_to(1e6, KEY("loop.rate_Hz", firmware.loop.rate_Hz, r::positive,
                               "ticks a second; must divide 1e9, as 400 or 250/3 with all its digits"))),
        up_to(1e6, KEY("loop.missed_time_budget_ms", firmware.loop.missed_time_budget_ms, r::not_negative,
                       "time that missed ticks may take before it is a fault")),
        KEY("loop.missed_time_refill_s", firmware.loop.missed_time_refill_s, r::positive,
            "time in which the whole budget of missed ticks comes back"),

        KEY("reflex.following_error_m", firmware.reflex.following_error_m, r::positive_or_inf,
            "distance between the robot's report and its setpoint beyond which the loop stops; inf: off"),
        KEY("reflex.following_error_ms", firmware.reflex.following_error_ms, r::not_negative,
            "how long the following error may be beyond its limit"),
        KEY("reflex.link_quality", firmware.reflex.link_quality, r::fraction,
            "share of ticks with a report of the robot, and with a force sample, below which the loop stops; 0: "
            "off"),
        KEY("reflex.link_quality_window_s", firmware.reflex.link_quality_window_s, r::positive,
            "time over which the link quality is counted"),
        KEY("reflex.dead_time_power_W", firmware.reflex.dead_time_power_W, r::positive_or_inf,
            "power made by the dead time beyond which the loop stops; inf: off"),
        KEY("reflex.dead_time_power_window_s", firmware.reflex.dead_time_power_window_s, r::positive,
            "time over which that power is averaged"),
        KEY("reflex.growth_J", firmware.reflex.growth_J, r::positive_or_inf,
            "energy of the manipulator that nobody gave it, beyond which the loop stops; inf: off"),

        KEY("feedback.gain", firmware.feedback.gain, r::fraction,
            "share of the measured force that the manipulator feels; 0: setpoints without feedback"),
        KEY("feedback.ramp_s", firmware.feedback.ramp_s, r::not_negative,
            "time in which the share would rise from 0 to 1, since the loop began to run; 0: at once"),

        from(1e-6, up_to(1e9, KEY("manipulator.mass_kg", firmware.manipulator.mass_kg, r::positive,
                                  "mass M of the simulated manipulator"))),
        up_to(1e12, KEY("manipulator.damping_N_s_per_m", firmware.manipulator.damping_N_s_per_m, r::not_negative,
                        "damping D of the simulated manipulator")),
        up_to(1e13, KEY("manipulator.stiffness_N_per_m", firmware.manipulator.stiffness_N_per_m, r::not_negative,
                        "stiffness K of the simulated manipulator")),
        KEY("manipulator.initial_position_m", firmware.manipulator.initial_position_m, r::any,
            "position at which the robot holds the manipulator until the release"),
        KEY("manipulator.initial_velocity_m_per_s", firmware.manipulator.initial_velocity_m_per_s, r::any,
            "velocity of the manipulator at the release"),
        KEY("manipulator.integrator", firmware.manipulator.integrator, r::any,
            "method that integrates the manipulator", {"exact", "semi_implicit_euler", "rk4"}),
        up_to(1000,
              KEY("manipulator.substeps", firmware.manipulator.substeps, r::positive, "integrator steps per tick")),
        KEY("manipulator.arm", arm, r::any,
            "a whole arm instead of the mass M, by name or file; theory and compensation then use M, D and K for "
            "it"),
        KEY("manipulator.direction_x", firmware.manipulator.direction_x, r::any,
            "x part of the robot's direction in the arm's world; its length does not count"),
        KEY("manipulator.direction_y", firmware.manipulator.direction_y, r::any, "y part of that direction"),
        KEY("manipulator.direction_z", firmware.manipulator.direction_z, r::any, "z part of that direction"),

        KEY("operator.interface", firmware.operator_command.interface, r::any,
            "the operator commands a motion (x_op, v_op) or a force on the manipulator", {"motion", "force"}),
        KEY("operator.bus", firmware.operator_command.bus, r::any,
            "bus from which the operator's commands and requests are taken; those on the other one are not heard",
            {"robot", "sensor"}),
        up_to(2.1, KEY("operator.position_limit_m", firmware.operator_command.position_limit_m, r::positive,
                       "largest commanded position; larger commands are rejected")),
        up_to(8.3, KEY("operator.velocity_limit_m_per_s", firmware.operator_command.velocity_limit_m_per_s,
                       r::positive, "largest commanded velocity; larger commands are rejected")),
        up_to(54000, KEY("operator.force_limit_N", firmware.operator_command.force_limit_N, r::positive,
                         "largest commanded force; larger commands are rejected")),
        KEY("operator.stale_after_ms", firmware.operator_command.stale_after_ms, r::positive,
            "age of the operator's command at which the loop holds"),

        KEY("profile.kind", profile.kind, r::any, "what the operator commands after the release",
            {"rest", "step", "ramp", "minimum_jerk", "chirp", "multisine", "triangle", "pulses", "file"}),
        KEY("profile.offset_m", profile.offset_m, r::any, "position about which the profile moves"),
        KEY("profile.amplitude_m", profile.amplitude_m, r::any,
            "amplitude of the motion, for operator.interface = \"motion\""),
        KEY("profile.amplitude_N", profile.amplitude_N, r::any,
            "amplitude of the force, for operator.interface = \"force\""),
        KEY("profile.start_s", profile.start_s, r::not_negative, "start of the profile, counted from the release"),
        KEY("profile.duration_s", profile.duration_s, r::positive,
            "length of ramp, move and chirp; period of the others"),
        KEY("profile.frequency_start_Hz", profile.frequency_start_Hz, r::positive,
            "first frequency of chirp and multisine"),
        KEY("profile.frequency_end_Hz", profile.frequency_end_Hz, r::positive,
            "last frequency of chirp and multisine; of pulses: that of their half sine"),
        KEY("profile.file", profile.file, r::any, "CSV (also .gz) with a header and a column t_s"),
        KEY("profile.column", profile.column, r::any,
            "column of the file; may be left empty if there is only one beside t_s"),
        KEY("profile.scale", profile.scale, r::any, "factor from the values of the file to m or N"),

        KEY("energy.position_age_ms", firmware.energy.position_age_ms, r::not_negative,
            "age of the robot's feedback when the loop uses it, for the energy account; 0: one period"),

        KEY("sensor_channel.layout", firmware.sensor_channel.layout, r::any, "frames of a sample, see berth.dbc",
            {"one_frame", "two_frames_intel", "two_frames_motorola", "three_frames_intel", "three_frames_motorola",
             "two_frames_unnumbered", "two_frames_unnumbered_split"}),
        KEY("sensor_channel.axis", firmware.sensor_channel.axis, r::any,
            "axis of a three-axis sensor along which the loop moves", {"x", "y", "z"}),
        KEY("sensor_channel.force_limit_N", firmware.sensor_channel.force_limit_N, r::positive,
            "largest measured force; a larger one is a fault"),
        KEY("sensor_channel.pairing_window_ms", firmware.sensor_channel.pairing_window_ms, r::positive,
            "frames without a number that come within this time of the first one are one sample; at most half the "
            "time between two samples"),
        KEY("sensor_channel.stale_after_ms", firmware.sensor_channel.stale_after_ms, r::positive,
            "age of the force sample at which the loop holds"),
        KEY("robot_channel.profile", firmware.robot_channel.profile, r::any,
            "frames of berth.dbc, or a CiA 402 drive on CANopen in cyclic synchronous position, see [cia402]",
            {"berth", "cia402"}),
        KEY("robot_channel.stale_after_ms", firmware.robot_channel.stale_after_ms, r::positive,
            "age of the robot's feedback that is a fault"),
        KEY("robot_channel.unsent_after_ms", firmware.robot_channel.unsent_after_ms, r::positive,
            "time that the bus may refuse frames before it is a fault"),
        KEY("robot_channel.setpoint_stale_after_ms", firmware.robot_channel.setpoint_stale_after_ms,
            r::positive_or_inf,
            "age of the newest setpoint that the robot echoes, that is a fault; inf: it does not echo"),
        KEY("robot_channel.start_tolerance_m", firmware.robot_channel.start_tolerance_m, r::positive,
            "largest distance between the robot and the first setpoint"),
        FLAG("robot_channel.watch_only", firmware.robot_channel.watch_only,
             "send no setpoint: the loop only watches"),

        up_to(127, KEY("cia402.node_id", firmware.cia402.node_id, r::positive, "node id of the drive")),
        up_to(127, KEY("cia402.master_node_id", firmware.cia402.master_node_id, r::positive,
                       "node id of the loop, for its heartbeat")),
        KEY("cia402.counts_per_m", firmware.cia402.counts_per_m, r::positive,
            "counts of the drive's target and actual position"),
        KEY("cia402.heartbeat_ms", firmware.cia402.heartbeat_ms, r::positive,
            "period of the heartbeats of drive and loop"),
        KEY("cia402.stale_after_ms", firmware.cia402.stale_after_ms, r::positive,
            "age of a heartbeat that is a fault, on either side"),
        KEY("cia402.sdo_timeout_ms", firmware.cia402.sdo_timeout_ms, r::positive,
            "time without an answer to an SDO that is a fault"),
        KEY("cia402.state_timeout_ms", firmware.cia402.state_timeout_ms, r::positive,
            "time that the drive may take to boot and to be enabled"),
        FLAG("cia402.must_watch_loop", firmware.cia402.must_watch_loop,
             "refuse a drive without objects 0x1016 and 0x100D, which would not stop when the loop dies"),
        KEY("cia402.homing_method", firmware.cia402.homing_method, r::any,
            "homing method of the drive (object 0x6098), at the start, which may move the robot; 0: none"),
        KEY("cia402.homing_timeout_ms", firmware.cia402.homing_timeout_ms, r::positive,
            "time that the drive may take for its homing"),
        KEY("cia402.encoder_counts", firmware.cia402.encoder_counts, r::not_negative,
            "encoder counts (object 0x608F) of cia402.encoder_revolutions; 0: as it is in the drive"),
        KEY("cia402.encoder_revolutions", firmware.cia402.encoder_revolutions, r::not_negative,
            "motor revolutions (object 0x608F) that cia402.encoder_counts belong to"),
        KEY("cia402.gear_motor_revolutions", firmware.cia402.gear_motor_revolutions, r::not_negative,
            "motor revolutions (object 0x6091) of cia402.gear_shaft_revolutions; 0: as it is in the drive"),
        KEY("cia402.gear_shaft_revolutions", firmware.cia402.gear_shaft_revolutions, r::not_negative,
            "shaft revolutions (object 0x6091) that cia402.gear_motor_revolutions belong to"),
        KEY("cia402.feed_counts", firmware.cia402.feed_counts, r::not_negative,
            "counts of the drive's position (object 0x6092) of cia402.feed_shaft_revolutions; 0: as it is in the "
            "drive"),
        KEY("cia402.feed_shaft_revolutions", firmware.cia402.feed_shaft_revolutions, r::not_negative,
            "shaft revolutions (object 0x6092) that cia402.feed_counts belong to"),
        KEY("cia402.polarity", firmware.cia402.polarity, r::any,
            "sign of the drive's positions (object 0x607E); as_it_is: not written",
            {"as_it_is", "normal", "reversed"}),
        from(-5.4, up_to(5.4, KEY("limits.position_min_m", firmware.limits.position_min_m, r::any,
                                  "smallest setpoint on the wire"))),
        from(-5.4, up_to(5.4, KEY("limits.position_max_m", firmware.limits.position_max_m, r::any,
                                  "largest setpoint on the wire"))),
        KEY("limits.velocity_m_per_s", firmware.limits.velocity_m_per_s, r::positive,
            "largest velocity of setpoints on the wire"),
        KEY("limits.acceleration_m_per_s2", firmware.limits.acceleration_m_per_s2, r::positive,
            "largest acceleration of setpoints on the wire"),
        FLAG("inverse_filter.enabled", firmware.inverse_filter.enabled,
             "the filter that takes away the amplitude error of robot.transfer_*"),
        KEY("inverse_filter.bandwidth_Hz", firmware.inverse_filter.bandwidth_Hz, r::positive,
            "frequency of the filter's own poles"),

        up_to(
            1e5,
            KEY("robot.dead_time_ms", robot.dead_time_ms, r::not_negative,
                "command to motion, time on the bus included; robot_channel.profile = \"cia402\": from the SYNC at "
                "which a "
                "setpoint acts, a period after the command")),
        KEY("robot.interpolation", robot.interpolation, r::any, "how the robot moves between setpoints",
            {"linear", "hold"}),
        from(1e-6, KEY("robot.transfer_frequency_Hz", robot.transfer_frequency_Hz, r::positive_or_inf,
                       "frequency of the second-order transfer behaviour; inf: none")),
        up_to(1e4, KEY("robot.transfer_damping_ratio", robot.transfer_damping_ratio, r::not_negative,
                       "damping ratio of the second-order transfer behaviour")),
        KEY("robot.velocity_limit_m_per_s", robot.velocity_limit_m_per_s, r::positive_or_inf,
            "largest velocity of the robot; inf: no limit"),
        KEY("robot.acceleration_limit_m_per_s2", robot.acceleration_limit_m_per_s2, r::positive_or_inf,
            "largest acceleration of the robot; inf: no limit"),
        KEY("robot.clock", robot.clock, r::any, "the robot takes setpoints when they come, or by a clock of its own",
            {"locked", "free"}),
        KEY("robot.clock_phase_ms", robot.clock_phase_ms, r::not_negative, "phase of a free clock"),
        from(-1e5, up_to(1e5, KEY("robot.clock_drift_ppm", robot.clock_drift_ppm, r::any,
                                  "rate error of a free clock; positive: slow"))),
        KEY("robot.jitter_ms", robot.jitter_ms, r::not_negative, "largest shift of a setpoint's instant"),
        KEY("robot.feedback_noise_m", robot.feedback_noise_m, r::not_negative,
            "noise of the position that the robot reports, standard deviation"),

        from(1e-6, up_to(1e13, KEY("sensor.stiffness_N_per_m", sensor.stiffness_N_per_m, r::positive,
                                   "stiffness k_S of the sensor"))),
        up_to(1e4, KEY("sensor.damping_ratio", sensor.damping_ratio, r::not_negative,
                       "damping ratio zeta_S of the sensor; d_S = 2 zeta_S sqrt(k_S m)")),
        up_to(2, KEY("sensor.low_pass_order", sensor.low_pass_order, r::not_negative,
                     "order of the sensor's low-pass: 0, 1 or 2")),
        from(1e-6, up_to(1e6, KEY("sensor.low_pass_frequency_Hz", sensor.low_pass_frequency_Hz, r::positive,
                                  "frequency f_L of the low-pass"))),
        KEY("sensor.low_pass_damping_ratio", sensor.low_pass_damping_ratio, r::positive,
            "damping ratio zeta_L of the low-pass, order 2"),
        up_to(1e5, KEY("sensor.delay_ms", sensor.delay_ms, r::not_negative,
                       "sample to arrival, time on the bus included")),
        KEY("sensor.sample_phase_ms", sensor.sample_phase_ms, r::not_negative, "time of the sample after the tick"),
        up_to(1e5, KEY("sensor.rate_Hz", sensor.rate_Hz, r::not_negative, "samples a second; 0: one a tick")),
        KEY("sensor.bias_N", sensor.bias_N, r::any, "force added to every sample"),
        KEY("sensor.noise_N", sensor.noise_N, r::not_negative,
            "noise of the force, standard deviation, one value a sample"),
        KEY("sensor.resolution_N", sensor.resolution_N, r::not_negative,
            "resolution of the force; 0: that of the frame"),
        KEY("sensor.saturation_N", sensor.saturation_N, r::positive_or_inf,
            "largest force that the sensor shows; inf: that of the frame"),
        KEY("sensor.loss_probability", sensor.loss_probability, r::fraction,
            "probability that a sample is never sent"),
        KEY("sensor.stale_probability", sensor.stale_probability, r::fraction,
            "probability that the last frame is sent again"),

        KEY("tare.enabled", tare.enabled, r::any, "take the sensor's zero and the tool's weight off every sample"),
        KEY("tare.force_x_N", tare.force_N[0], r::any,
            "zero of the force sensor along its x axis; of a sensor of one axis: of that"),
        KEY("tare.force_y_N", tare.force_N[1], r::any, "zero of the force along y"),
        KEY("tare.force_z_N", tare.force_N[2], r::any, "zero of the force along z"),
        KEY("tare.torque_x_N_m", tare.torque_N_m[0], r::any, "zero of the torque about the sensor's x axis"),
        KEY("tare.torque_y_N_m", tare.torque_N_m[1], r::any, "zero of the torque about y"),
        KEY("tare.torque_z_N_m", tare.torque_N_m[2], r::any, "zero of the torque about z"),

        KEY("tool.mass_kg", tool.mass_kg, r::not_negative,
            "mass that hangs on the sensor in 1 g; its weight is taken off, its inertia is sensor.tool_mass_kg"),
        KEY("tool.centre_x_m", tool.centre_m[0], r::any, "its centre of mass in the sensor's axes"),
        KEY("tool.centre_y_m", tool.centre_m[1], r::any, "the same along y"),
        KEY("tool.centre_z_m", tool.centre_m[2], r::any, "the same along z"),
        KEY("tool.gravity_x_m_per_s2", tool.gravity_m_per_s2[0], r::any,
            "acceleration of gravity in the sensor's axes; of a sensor of one axis: along that"),
        KEY("tool.gravity_y_m_per_s2", tool.gravity_m_per_s2[1], r::any, "the same along y"),
        KEY("tool.gravity_z_m_per_s2", tool.gravity_m_per_s2[2], r::any, "the same along z"),

        KEY("object.kind", object.kind, r::any,
            "what the robot meets: gripped (a mass on a spring), contact (elastic material, which a tool pushes), "
            "beam (of several modes), none (it touches nothing)",
            {"gripped", "contact", "beam", "none"}),
        from(1e-6, up_to(1e9, KEY("object.mass_kg", object.mass_kg, r::positive,
                                  "mass m of the object; contact: of the tool"))),
        up_to(1e13, KEY("object.stiffness_N_per_m", object.stiffness_N_per_m, r::not_negative,
                        "stiffness k of the object")),
        up_to(1e12,
              KEY("object.damping_N_s_per_m", object.damping_N_s_per_m, r::not_negative, "damping d of the object")),
        KEY("object.surface_position_m", object.surface_position_m, r::any,
            "contact: material beyond this position"),
        up_to(8, KEY("object.modes", object.modes, r::positive, "beam: how many modes count, 1 to 8")),
        KEY("object.beam_length_m", object.beam.length_m, r::positive, "beam: from its root to where it is gripped"),
        KEY("object.beam_mass_kg_per_m", object.beam.mass_kg_per_m, r::positive, "beam: mass per length"),
        KEY("object.beam_stiffness_N_m2", object.beam.bending_stiffness_N_m2, r::positive,
            "beam: bending stiffness E I"),
        KEY("object.beam_root_stiffness_N_m_per_rad", object.beam.root_N_m_per_rad, r::positive_or_inf,
            "beam: stiffness of the spring at its root; inf: clamped"),
        KEY("object.beam_damping_ratio", object.beam.damping_ratio, r::fraction,
            "beam: damping ratio of every mode"),

        KEY("bus.bit_rate_bit_per_s", bus.bit_rate_bit_per_s, r::positive, "bit rate of both buses"),
        KEY("bus.ideal", bus.ideal, r::any, "frames take no time"),
        KEY("bus.loss_probability", bus.loss_probability, r::fraction, "probability that a frame is lost"),
        KEY("bus.burst_probability", bus.burst_probability, r::fraction,
            "probability that a burst of losses starts"),
        from(1, KEY("bus.burst_length_frames", bus.burst_length_frames, r::positive, "mean length of a burst")),
        up_to(0.9, KEY("bus.error_probability", bus.error_probability, r::fraction,
                       "probability that a frame is destroyed and sent again")),

        up_to(3, KEY("extrapolation.order", firmware.extrapolation.order, r::not_negative,
                     "order of the extrapolation of setpoints over the delay, 1 to 3; 0: none")),
        KEY("extrapolation.delay_ms", firmware.extrapolation.delay_ms, r::not_negative,
            "delay to extrapolate over; 0: what other units leave of the loop's"),
        FLAG("adaptive_inverse.enabled", firmware.adaptive_inverse.enabled,
             "setpoints with which the robot is where the manipulator is now, corrected by the positions that it "
             "reports"),
        up_to(0.33, KEY("adaptive_inverse.tolerance", firmware.adaptive_inverse.tolerance, r::not_negative,
                        "share to which the robot's delay is known beforehand; 0: it stays as given")),
        up_to(0.3, KEY("adaptive_inverse.gain_tolerance", firmware.adaptive_inverse.gain_tolerance, r::not_negative,
                       "share to which the robot's gain is known beforehand; 0: it stays as given")),
        KEY("adaptive_inverse.bandwidth_Hz", firmware.adaptive_inverse.bandwidth_Hz, r::positive,
            "bandwidth of the motion that it is fitted to"),
        KEY("adaptive_inverse.position_noise_m", firmware.adaptive_inverse.position_noise_m, r::positive,
            "noise of the robot's reports, standard deviation"),
        KEY("adaptive_inverse.memory_s", firmware.adaptive_inverse.memory_s, r::positive,
            "time of motion after which it forgets"),
        KEY("adaptive_inverse.correction_max_m", firmware.adaptive_inverse.correction_max_m, r::positive,
            "largest distance between the manipulator's position and the setpoint"),
        FLAG("force_lead.enabled", firmware.force_lead.enabled,
             "the measured force, brought forward by the model of the object"),
        KEY("force_lead.age_ms", firmware.force_lead.age_ms, r::not_negative,
            "age of the force, over which it is led; 0: what the motion side leaves of the loop's dead time"),
        KEY("force_lead.error_bandwidth_Hz", firmware.force_lead.error_bandwidth_Hz, r::positive_or_inf,
            "frequency up to which the measured force corrects the model; inf: at once"),
        FLAG("prediction.enabled", firmware.prediction.enabled,
             "the manipulator feels the object of the rig file without dead time, corrected by the measured force"),
        KEY("prediction.error_bandwidth_Hz", firmware.prediction.error_bandwidth_Hz, r::not_negative,
            "frequency up to which the measured force corrects the model"),
        KEY("prediction.dead_time_ms", firmware.prediction.dead_time_ms, r::positive_or_inf,
            "dead time of the robot in the model; inf: that of the rig"),
        KEY("prediction.mass_kg", firmware.prediction.mass_kg, r::positive_or_inf,
            "mass of the object in the model; inf: that of the rig"),
        KEY("prediction.damping_N_s_per_m", firmware.prediction.damping_N_s_per_m, r::not_negative_or_inf,
            "damping of the object in the model; inf: that of the rig"),
        KEY("prediction.stiffness_N_per_m", firmware.prediction.stiffness_N_per_m, r::not_negative_or_inf,
            "stiffness of the object in the model; inf: that of the rig"),
        FLAG("identification.enabled", firmware.identification.enabled,
             "identify the object's mass, damping and stiffness, and the robot's dead time, while the loop runs"),
        up_to(1, KEY("identification.tolerance", firmware.identification.tolerance, r::positive,
                     "share to which they are known beforehand")),
        KEY("identification.noise_N", firmware.identification.noise_N, r::positive,
            "noise of the force sensor, standard deviation"),
        KEY("identification.position_noise_m", firmware.identification.position_noise_m, r::positive,
            "noise of the robot's reports, standard deviation"),
        KEY("identification.memory_s", firmware.identification.memory_s, r::positive, "time after which it forgets"),
        KEY("passivity.action", firmware.passivity.action, r::any,
            "on energy that the manipulator gets out of nothing: a damper, or a tank that gives no more than it has",
            {"off", "damping", "tank"}),
        KEY("passivity.reference", firmware.passivity.reference, r::any,
            "how much may come back: what was given, or what the measured port says", {"zero", "measured"}),
        KEY("passivity.credit_J", firmware.passivity.credit_J, r::not_negative,
            "energy that may come back at the start, and at most"),
        KEY("passivity.horizon_ms", firmware.passivity.horizon_ms, r::positive,
            "time over which a deficit is taken away"),
        KEY("passivity.damping_max_N_s_per_m", firmware.passivity.damping_max_N_s_per_m, r::not_negative,
            "largest damping of the damper; what it cannot take is carried over"),
        KEY("dissipation.damping_N_s_per_m", firmware.dissipation.damping_N_s_per_m, r::not_negative,
            "damping of a damper between manipulator and command that is always there"),

        KEY("solver.kind", solver.kind, r::any, "solver of the simulated rig", {"fast", "cvode"}),
        KEY("solver.relative_tolerance", solver.relative_tolerance, r::positive, "relative tolerance of cvode"),
        KEY("solver.absolute_tolerance_m", solver.absolute_tolerance_m, r::positive,
            "absolute tolerance of cvode for the object's position; the other states in proportion"),
        from(0.01, KEY("solver.contact_step_us", solver.contact_step_us, r::positive,
                       "step of the fast solver with object.kind = \"contact\"")),

        KEY("target.robot_interface", target.robot_interface, r::any, "CAN interface of the robot's bus"),
        KEY("target.sensor_interface", target.sensor_interface, r::any, "CAN interface of the sensor's bus"),
        KEY("target.gpio_chip", target.gpio_chip, r::any,
            "chip that has the lines, by name (gpiochip0) or label; empty: look on all"),
        KEY("target.emergency_stop_line", target.emergency_stop_line, r::any,
            "input of the emergency stop, by name; empty: not wired"),
        KEY("target.emergency_stop_active_low", target.emergency_stop_active_low, r::any,
            "a low input means pressed, so that a broken wire is a pressed button"),
        KEY("target.enable_line", target.enable_line, r::any,
            "input of enable, by name; empty: not wired, always enabled"),
        KEY("target.enable_active_low", target.enable_active_low, r::any, "a low input means enabled"),
        KEY("target.heartbeat_line", target.heartbeat_line, r::any,
            "output that toggles every tick; empty: not wired"),
        KEY("target.tick_line", target.tick_line, r::any,
            "output that is high from wake-up to the end of the tick; empty: not wired"),
        KEY("target.fault_line", target.fault_line, r::any,
            "output that is high while the supervisor is in fault; empty: not wired"),
        KEY("target.cpu", target.cpu, r::any, "processor that the loop is bound to; negative: any"),
        up_to(98, KEY("target.priority", target.priority, r::positive, "SCHED_FIFO priority of the loop, 1 to 98")),
        KEY("target.watchdog_device", target.watchdog_device, r::any,
            "watchdog device, as /dev/watchdog; \"auto\": that one if there is one; empty: none"),
        KEY("target.log_path", target.log_path, r::any, "where the log goes if the command line names none"),
    };
}

/* Those of the effects stand behind the last one of their section. */
std::vector<rig_key> make_keys()
{
    std::vector<rig_key> keys = make_own_keys();
    std::size_t next_value = 0;
    for (const effect_key &effect : effect_keys()) {
        rig_key key = make_key<double>(effect.path, nullptr, range::any, effect.meaning);
        key.low = effect.low;
        key.effect_value = next_value++;
        const std::string_view section = effect.path.substr(0, effect.path.find('.') + 1);
        const auto last = std::find_if(keys.rbegin(), keys.rend(), [&](const rig_key &known) {
            return known.path.substr(0, section.size()) == section;
        });
        keys.insert(last.base(), key);
    }
    return keys;
}

} // namespace berth
