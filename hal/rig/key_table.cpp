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

#define KEY(path, member, ...)                                                                                      \
    make_key<decltype(rig::member)>(                                                                                \
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
        KEY("run.seed", run.seed, r::not_negative, "of every random draw"),
        KEY("run.lateness_file", run.lateness_file, r::any,
            "how late the loop wakes: JSON of cyclictest with a histogram; empty: never"),
        KEY("run.emergency_stop_s", run.emergency_stop_s, r::not_negative_or_inf,
            "emergency stop is pressed; inf: never"),
        KEY("run.enable_off_s", run.enable_off_s, r::not_negative_or_inf, "enable is taken away; inf: never"),
        KEY("run.grip_close_s", run.grip_close_s, r::not_negative,
            "the gripper closes on the object where both are; 0: gripped from the start"),
        KEY("run.grip_release_s", run.grip_release_s, r::not_negative_or_inf,
            "the gripped object is let go, for good; inf: never"),
        KEY("run.dead_time_jump_s", run.dead_time_jump_s, r::not_negative_or_inf,
            "the robot's dead time changes; inf: never"),
        KEY("run.dead_time_jump_ms", run.dead_time_jump_ms, r::any, "by which it is longer from then on"),

        KEY("loop.rate_Hz", firmware.loop.rate_Hz, r::positive,
            "ticks a second; must divide 1e9, as 400 or 250/3 with all its digits"),
        KEY("loop.missed_time_budget_ms", firmware.loop.missed_time_budget_ms, r::not_negative,
            "that missed ticks may take before it is a fault"),
        KEY("loop.missed_time_refill_s", firmware.loop.missed_time_refill_s, r::positive,
            "in which the whole budget comes back"),

        KEY("reflex.following_error_m", firmware.reflex.following_error_m, r::positive_or_inf,
            "robot's report to the setpoint that belongs to it, beyond which the loop stops; inf: off"),
        KEY("reflex.following_error_ms", firmware.reflex.following_error_ms, r::not_negative,
            "for how long it may be beyond it"),
        KEY("reflex.link_quality", firmware.reflex.link_quality, r::fraction,
            "share of ticks with a report of the robot, and with a force sample, below which the loop stops; 0: "
            "off"),
        KEY("reflex.link_quality_window_s", firmware.reflex.link_quality_window_s, r::positive,
            "over which they are counted"),
        KEY("reflex.dead_time_power_W", firmware.reflex.dead_time_power_W, r::positive_or_inf,
            "made by dead time, beyond which the loop stops; inf: off"),
        KEY("reflex.dead_time_power_window_s", firmware.reflex.dead_time_power_window_s, r::positive,
            "over which it is the mean"),
        KEY("reflex.growth_J", firmware.reflex.growth_J, r::positive_or_inf,
            "energy of the manipulator that nobody gave it, beyond which the loop stops; inf: off"),

        KEY("manipulator.mass_kg", firmware.manipulator.mass_kg, r::positive, "M"),
        KEY("manipulator.damping_N_s_per_m", firmware.manipulator.damping_N_s_per_m, r::not_negative, "D"),
        KEY("manipulator.stiffness_N_per_m", firmware.manipulator.stiffness_N_per_m, r::not_negative, "K"),
        KEY("manipulator.initial_position_m", firmware.manipulator.initial_position_m, r::any,
            "where the robot holds it until the release"),
        KEY("manipulator.initial_velocity_m_per_s", firmware.manipulator.initial_velocity_m_per_s, r::any,
            "at the release"),
        KEY("manipulator.integrator", firmware.manipulator.integrator, r::any, "of the manipulator step",
            {"exact", "semi_implicit_euler", "rk4"}),
        KEY("manipulator.substeps", firmware.manipulator.substeps, r::positive, "integrator steps per tick"),
        KEY("manipulator.arm", arm, r::any,
            "a whole arm in its place, by name or file; M, D and K are then what it is taken for by theory and "
            "compensation"),
        KEY("manipulator.direction_x", firmware.manipulator.direction_x, r::any,
            "of the robot in the arm's world, of any length"),
        KEY("manipulator.direction_y", firmware.manipulator.direction_y, r::any, "of the same"),
        KEY("manipulator.direction_z", firmware.manipulator.direction_z, r::any, "of the same"),

        KEY("operator.interface", firmware.operator_command.interface, r::any,
            "commands a motion (x_op, v_op) or a force on the manipulator", {"motion", "force"}),
        KEY("operator.position_limit_m", firmware.operator_command.position_limit_m, r::positive,
            "larger commands are rejected"),
        KEY("operator.velocity_limit_m_per_s", firmware.operator_command.velocity_limit_m_per_s, r::positive,
            "larger commands are rejected"),
        KEY("operator.force_limit_N", firmware.operator_command.force_limit_N, r::positive,
            "larger commands are rejected"),
        KEY("operator.stale_after_ms", firmware.operator_command.stale_after_ms, r::positive,
            "age at which the loop holds"),

        KEY("profile.kind", profile.kind, r::any, "what the operator commands after the release",
            {"rest", "step", "ramp", "minimum_jerk", "chirp", "multisine", "triangle", "pulses", "file"}),
        KEY("profile.offset_m", profile.offset_m, r::any, "position about which the profile moves"),
        KEY("profile.amplitude_m", profile.amplitude_m, r::any, "for operator.interface = \"motion\""),
        KEY("profile.amplitude_N", profile.amplitude_N, r::any, "for operator.interface = \"force\""),
        KEY("profile.start_s", profile.start_s, r::not_negative, "after the release"),
        KEY("profile.duration_s", profile.duration_s, r::positive, "of ramp, move, chirp; period of the others"),
        KEY("profile.frequency_start_Hz", profile.frequency_start_Hz, r::positive, "of chirp and multisine"),
        KEY("profile.frequency_end_Hz", profile.frequency_end_Hz, r::positive,
            "of chirp and multisine; of the half sine that a pulse is"),
        KEY("profile.file", profile.file, r::any, "CSV (also .gz) with a header and a column t_s"),
        KEY("profile.column", profile.column, r::any,
            "of the file; may be left empty if there is only one beside t_s"),
        KEY("profile.scale", profile.scale, r::any, "file value to m or N"),

        KEY("energy.position_age_ms", firmware.energy.position_age_ms, r::not_negative,
            "of the robot's feedback when the loop uses it, for the energy account; 0: one period"),

        KEY("sensor_channel.layout", firmware.sensor_channel.layout, r::any, "frames of a sample, see berth.dbc",
            {"one_frame", "two_frames_intel", "two_frames_motorola", "three_frames_intel", "three_frames_motorola"}),
        KEY("sensor_channel.axis", firmware.sensor_channel.axis, r::any,
            "of a sensor with three, the one along which the loop moves", {"x", "y", "z"}),
        KEY("sensor_channel.force_limit_N", firmware.sensor_channel.force_limit_N, r::positive,
            "larger measured forces are a fault"),
        KEY("sensor_channel.stale_after_ms", firmware.sensor_channel.stale_after_ms, r::positive,
            "age at which the loop holds"),
        KEY("robot_channel.profile", firmware.robot_channel.profile, r::any,
            "frames of berth.dbc, or a CiA 402 drive on CANopen in cyclic synchronous position, see [cia402]",
            {"berth", "cia402"}),
        KEY("robot_channel.stale_after_ms", firmware.robot_channel.stale_after_ms, r::positive,
            "age of feedback that is a fault"),
        KEY("robot_channel.unsent_after_ms", firmware.robot_channel.unsent_after_ms, r::positive,
            "frames that the bus does not take for longer are a fault"),
        KEY("robot_channel.setpoint_stale_after_ms", firmware.robot_channel.setpoint_stale_after_ms,
            r::positive_or_inf,
            "age of the newest setpoint that the robot echoes, that is a fault; inf: it does not echo"),
        KEY("robot_channel.start_tolerance_m", firmware.robot_channel.start_tolerance_m, r::positive,
            "robot to first setpoint"),

        KEY("cia402.node_id", firmware.cia402.node_id, r::positive, "of the drive"),
        KEY("cia402.master_node_id", firmware.cia402.master_node_id, r::positive, "of the loop, for its heartbeat"),
        KEY("cia402.counts_per_m", firmware.cia402.counts_per_m, r::positive,
            "of the drive's target and actual position"),
        KEY("cia402.heartbeat_ms", firmware.cia402.heartbeat_ms, r::positive, "the drive's and the loop's"),
        KEY("cia402.stale_after_ms", firmware.cia402.stale_after_ms, r::positive,
            "age of a heartbeat that is a fault, on either side"),
        KEY("cia402.sdo_timeout_ms", firmware.cia402.sdo_timeout_ms, r::positive,
            "without an answer to an SDO, a fault"),
        KEY("cia402.state_timeout_ms", firmware.cia402.state_timeout_ms, r::positive,
            "for the drive to boot and to be enabled"),
        FLAG("cia402.must_watch_loop", firmware.cia402.must_watch_loop,
             "refuse a drive without object 0x1016, which would not stop when the loop dies"),
        KEY("limits.position_min_m", firmware.limits.position_min_m, r::any, "of setpoints on the wire"),
        KEY("limits.position_max_m", firmware.limits.position_max_m, r::any, "of setpoints on the wire"),
        KEY("limits.velocity_m_per_s", firmware.limits.velocity_m_per_s, r::positive, "of setpoints on the wire"),
        KEY("limits.acceleration_m_per_s2", firmware.limits.acceleration_m_per_s2, r::positive,
            "of setpoints on the wire"),
        FLAG("inverse_filter.enabled", firmware.inverse_filter.enabled,
             "takes away the amplitude error of robot.transfer_*"),
        KEY("inverse_filter.bandwidth_Hz", firmware.inverse_filter.bandwidth_Hz, r::positive,
            "of the filter's own poles"),

        KEY("robot.dead_time_ms", robot.dead_time_ms, r::not_negative,
            "command to motion, time on the bus included; robot_channel.profile = \"cia402\": from the SYNC at "
            "which a "
            "setpoint acts, a period after the command"),
        KEY("robot.interpolation", robot.interpolation, r::any, "between setpoints", {"linear", "hold"}),
        KEY("robot.transfer_frequency_Hz", robot.transfer_frequency_Hz, r::positive_or_inf,
            "of the second-order transfer behaviour; inf: none"),
        KEY("robot.transfer_damping_ratio", robot.transfer_damping_ratio, r::not_negative, "of the same"),
        KEY("robot.velocity_limit_m_per_s", robot.velocity_limit_m_per_s, r::positive_or_inf, "inf: none"),
        KEY("robot.acceleration_limit_m_per_s2", robot.acceleration_limit_m_per_s2, r::positive_or_inf, "inf: none"),
        KEY("robot.clock", robot.clock, r::any, "takes setpoints when they come, or by a clock of its own",
            {"locked", "free"}),
        KEY("robot.clock_phase_ms", robot.clock_phase_ms, r::not_negative, "of a free clock"),
        KEY("robot.clock_drift_ppm", robot.clock_drift_ppm, r::any, "of a free clock; positive: slow"),
        KEY("robot.jitter_ms", robot.jitter_ms, r::not_negative, "largest shift of a setpoint's instant"),
        KEY("robot.feedback_noise_m", robot.feedback_noise_m, r::not_negative,
            "standard deviation of the position that it reports"),

        KEY("sensor.stiffness_N_per_m", sensor.stiffness_N_per_m, r::positive, "k_S"),
        KEY("sensor.damping_ratio", sensor.damping_ratio, r::not_negative, "zeta_S; d_S = 2 zeta_S sqrt(k_S m)"),
        KEY("sensor.low_pass_order", sensor.low_pass_order, r::not_negative, "0, 1 or 2"),
        KEY("sensor.low_pass_frequency_Hz", sensor.low_pass_frequency_Hz, r::positive, "f_L"),
        KEY("sensor.low_pass_damping_ratio", sensor.low_pass_damping_ratio, r::positive, "zeta_L, order 2"),
        KEY("sensor.delay_ms", sensor.delay_ms, r::not_negative, "sample to arrival, time on the bus included"),
        KEY("sensor.sample_phase_ms", sensor.sample_phase_ms, r::not_negative, "sample after the tick"),
        KEY("sensor.rate_Hz", sensor.rate_Hz, r::not_negative, "samples a second; 0: one a tick"),
        KEY("sensor.bias_N", sensor.bias_N, r::any, "added to every sample"),
        KEY("sensor.noise_N", sensor.noise_N, r::not_negative, "standard deviation, one value a sample"),
        KEY("sensor.resolution_N", sensor.resolution_N, r::not_negative, "0: that of the frame"),
        KEY("sensor.saturation_N", sensor.saturation_N, r::positive_or_inf, "inf: that of the frame"),
        KEY("sensor.loss_probability", sensor.loss_probability, r::fraction, "a sample is never sent"),
        KEY("sensor.stale_probability", sensor.stale_probability, r::fraction, "the last frame is sent again"),

        KEY("object.kind", object.kind, r::any,
            "gripped object, a tool that pushes on elastic material, a gripped beam, or none: the robot touches "
            "nothing",
            {"gripped", "contact", "beam", "none"}),
        KEY("object.mass_kg", object.mass_kg, r::positive, "m; contact: of the tool"),
        KEY("object.stiffness_N_per_m", object.stiffness_N_per_m, r::not_negative, "k"),
        KEY("object.damping_N_s_per_m", object.damping_N_s_per_m, r::not_negative, "d"),
        KEY("object.surface_position_m", object.surface_position_m, r::any,
            "contact: material beyond this position"),
        KEY("object.modes", object.modes, r::positive, "beam: how many count, 1 to 8"),
        KEY("object.beam_length_m", object.beam.length_m, r::positive, "beam: from its root to where it is gripped"),
        KEY("object.beam_mass_kg_per_m", object.beam.mass_kg_per_m, r::positive, "beam: mass a length"),
        KEY("object.beam_stiffness_N_m2", object.beam.bending_stiffness_N_m2, r::positive, "beam: E I"),
        KEY("object.beam_root_stiffness_N_m_per_rad", object.beam.root_N_m_per_rad, r::positive_or_inf,
            "beam: of the spring at its root; inf: clamped"),
        KEY("object.beam_damping_ratio", object.beam.damping_ratio, r::fraction, "beam: of every mode"),

        KEY("bus.bit_rate_bit_per_s", bus.bit_rate_bit_per_s, r::positive, "of both buses"),
        KEY("bus.ideal", bus.ideal, r::any, "frames take no time"),
        KEY("bus.loss_probability", bus.loss_probability, r::fraction, "a frame is lost"),
        KEY("bus.burst_probability", bus.burst_probability, r::fraction, "a burst of losses starts"),
        KEY("bus.burst_length_frames", bus.burst_length_frames, r::positive, "mean length of a burst"),
        KEY("bus.error_probability", bus.error_probability, r::fraction, "a frame is destroyed and sent again"),

        KEY("extrapolation.order", firmware.extrapolation.order, r::not_negative,
            "of setpoints over the delay, 1 to 3; 0: none"),
        KEY("extrapolation.delay_ms", firmware.extrapolation.delay_ms, r::not_negative,
            "0: what other units leave of the loop's"),
        FLAG("adaptive_inverse.enabled", firmware.adaptive_inverse.enabled,
             "setpoints with which the robot is where the manipulator is now, corrected by the positions that it "
             "reports"),
        KEY("adaptive_inverse.tolerance", firmware.adaptive_inverse.tolerance, r::not_negative,
            "to which the robot's delay is known beforehand, as a share; 0: it stays as told"),
        KEY("adaptive_inverse.gain_tolerance", firmware.adaptive_inverse.gain_tolerance, r::not_negative,
            "the same of its gain"),
        KEY("adaptive_inverse.bandwidth_Hz", firmware.adaptive_inverse.bandwidth_Hz, r::positive,
            "of the motion that it is fitted to"),
        KEY("adaptive_inverse.position_noise_m", firmware.adaptive_inverse.position_noise_m, r::positive,
            "of the robot's reports: standard deviation"),
        KEY("adaptive_inverse.memory_s", firmware.adaptive_inverse.memory_s, r::positive,
            "of motion, after which it forgets"),
        KEY("adaptive_inverse.correction_max_m", firmware.adaptive_inverse.correction_max_m, r::positive,
            "between the manipulator's position and the setpoint"),
        FLAG("force_lead.enabled", firmware.force_lead.enabled,
             "the measured force, brought forward by the model of the object"),
        KEY("force_lead.age_ms", firmware.force_lead.age_ms, r::not_negative,
            "of the force, over which it is led; 0: what the motion side leaves of the loop's dead time"),
        KEY("force_lead.error_bandwidth_Hz", firmware.force_lead.error_bandwidth_Hz, r::positive_or_inf,
            "up to which the measured force corrects the model; inf: at once"),
        FLAG("prediction.enabled", firmware.prediction.enabled,
             "the manipulator feels the object of the rig file without dead time, corrected by the measured force"),
        KEY("prediction.error_bandwidth_Hz", firmware.prediction.error_bandwidth_Hz, r::not_negative,
            "up to which the measured force corrects the model"),
        KEY("prediction.dead_time_ms", firmware.prediction.dead_time_ms, r::positive_or_inf,
            "what the model takes for the robot's; inf: that of the rig"),
        KEY("prediction.mass_kg", firmware.prediction.mass_kg, r::positive_or_inf,
            "what the model takes for the object's; inf: that of the rig"),
        KEY("prediction.damping_N_s_per_m", firmware.prediction.damping_N_s_per_m, r::not_negative_or_inf,
            "what the model takes for the object's; inf: that of the rig"),
        KEY("prediction.stiffness_N_per_m", firmware.prediction.stiffness_N_per_m, r::not_negative_or_inf,
            "what the model takes for the object's; inf: that of the rig"),
        FLAG("identification.enabled", firmware.identification.enabled,
             "of the object's mass, damping and stiffness, and of the robot's dead time, while the loop runs"),
        KEY("identification.tolerance", firmware.identification.tolerance, r::positive,
            "to which they are known beforehand, as a share"),
        KEY("identification.noise_N", firmware.identification.noise_N, r::positive,
            "of the force sensor: standard deviation"),
        KEY("identification.position_noise_m", firmware.identification.position_noise_m, r::positive,
            "of the robot's reports: standard deviation"),
        KEY("identification.memory_s", firmware.identification.memory_s, r::positive, "after which it forgets"),
        KEY("passivity.action", firmware.passivity.action, r::any,
            "on energy that the manipulator gets out of nothing: a damper, or a tank that gives no more than it has",
            {"off", "damping", "tank"}),
        KEY("passivity.reference", firmware.passivity.reference, r::any,
            "how much may come back: what was given, or what the measured port says", {"zero", "measured"}),
        KEY("passivity.credit_J", firmware.passivity.credit_J, r::not_negative, "at the start, and at most"),
        KEY("passivity.horizon_ms", firmware.passivity.horizon_ms, r::positive,
            "over which a deficit is taken away"),
        KEY("passivity.damping_max_N_s_per_m", firmware.passivity.damping_max_N_s_per_m, r::not_negative,
            "of the damper; what it cannot take is carried over"),
        KEY("dissipation.damping_N_s_per_m", firmware.dissipation.damping_N_s_per_m, r::not_negative,
            "of a damper between manipulator and command that is always there"),

        KEY("solver.kind", solver.kind, r::any, "of the simulated rig", {"fast", "cvode"}),
        KEY("solver.relative_tolerance", solver.relative_tolerance, r::positive, "cvode"),
        KEY("solver.absolute_tolerance_m", solver.absolute_tolerance_m, r::positive,
            "cvode; of the object's position, other states in proportion"),
        KEY("solver.contact_step_us", solver.contact_step_us, r::positive, "fast solver, object.kind = \"contact\""),

        KEY("target.robot_interface", target.robot_interface, r::any, "CAN interface of the robot's bus"),
        KEY("target.sensor_interface", target.sensor_interface, r::any, "CAN interface of the sensor's bus"),
        KEY("target.gpio_chip", target.gpio_chip, r::any,
            "that has the lines, by name (gpiochip0) or label; empty: look on all"),
        KEY("target.emergency_stop_line", target.emergency_stop_line, r::any, "in, by name; empty: not wired"),
        KEY("target.emergency_stop_active_low", target.emergency_stop_active_low, r::any,
            "low means pressed, so that a broken wire is a pressed button"),
        KEY("target.enable_line", target.enable_line, r::any, "in, by name; empty: not wired, always enabled"),
        KEY("target.enable_active_low", target.enable_active_low, r::any, "low means enabled"),
        KEY("target.heartbeat_line", target.heartbeat_line, r::any, "out, toggles every tick; empty: not wired"),
        KEY("target.tick_line", target.tick_line, r::any,
            "out, high from wake-up to the end of the tick; empty: not wired"),
        KEY("target.fault_line", target.fault_line, r::any,
            "out, high while the supervisor is in fault; empty: not wired"),
        KEY("target.cpu", target.cpu, r::any, "that the loop is bound to; negative: any"),
        KEY("target.priority", target.priority, r::positive, "SCHED_FIFO priority of the loop, 1 to 98"),
        KEY("target.watchdog_device", target.watchdog_device, r::any, "as /dev/watchdog; empty: none"),
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
