#include "rig.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../../firmware/arm/arm_motion.h"
#include "../../firmware/compensation/compensation.h"
#include "../../firmware/sensor_layout.h"
#include "../../firmware/types.h"
#include "axes.h"
#include "beam.h"
#include "given.h"
#include "hardware_model.h"
#include "keys.h"
#include "orders.h"
#include "tool_load.h"

namespace berth
{

namespace
{

std::string near_rates(const app_config &config)
{
    const auto is_fit = [&](std::int64_t rate_Hz) {
        app_config other = config;
        other.loop.rate_Hz = static_cast<double>(rate_Hz);
        return NS_PER_S % rate_Hz == 0 && (config_interpolation_period(&other).value != 0 ||
                                           other.robot_channel.profile != ROBOT_PROFILE_CIA402);
    };
    auto below = static_cast<std::int64_t>(std::floor(config.loop.rate_Hz));
    auto above = static_cast<std::int64_t>(std::ceil(config.loop.rate_Hz));
    while (!is_fit(below)) {
        below--;
    }
    while (!is_fit(above)) {
        above++;
    }
    return "; the nearest whole rates that do are " + std::to_string(below) + " and " + std::to_string(above) +
           " Hz (a record has any rate: to diagnose one, leave it out)";
}

constexpr std::int64_t status_frames_a_second = 10;

constexpr std::size_t interface_bytes = 16; /* IFNAMSIZ */

std::optional<rig_error> check_bus(const rig &rig)
{
    const auto frames_a_second = static_cast<std::int64_t>(std::ceil(static_cast<double>(robot_frames_a_tick(rig)) *
                                                                     rig.firmware.loop.rate_Hz)) +
                                 status_frames_a_second;
    if (frames_a_second * frame_time_ns(rig.bus, 8) > NS_PER_S) {
        return rig_error{"bus.bit_rate_bit_per_s",
                         "is too low for " + std::to_string(frames_a_second) +
                             " frames a second on the robot's bus (feedback, operator command and setpoint in each "
                             "tick): they would queue up; lower loop.rate_Hz or set bus.ideal = true"};
    }
    return {};
}

std::optional<rig_error> check_robot(const rig &rig)
{
    const double period_ms = 1e3 * config_period_s(&rig.firmware);
    const robot_rig &robot = rig.robot;
    if (robot.dead_time_ms > 1e5) {
        return rig_error{"robot.dead_time_ms", "must be at most 100000 ms"};
    }
    const bool is_too_short = ns_from_ms(robot.dead_time_ms) < least_dead_time_ns(rig) && !is_robot_alone(rig);
    if (robot.interpolation == interpolation::linear && is_too_short) {
        return rig_error{"robot.dead_time_ms",
                         "must be at least one period (" + std::to_string(period_ms) +
                             " ms) with robot.interpolation = \"linear\": the robot must know the next setpoint to "
                             "move towards it; use \"hold\" for shorter dead times"};
    }
    if (robot.interpolation == interpolation::hold && is_too_short) {
        return rig_error{"robot.dead_time_ms",
                         "is shorter than the setpoint's time on the bus, which it includes (feedback and operator "
                         "command go first); set bus.ideal = true"};
    }
    if (robot.clock == robot_clock::free && rig.firmware.robot_channel.profile == ROBOT_PROFILE_CIA402) {
        return rig_error{"robot.clock",
                         "must be locked with robot_channel.profile = \"cia402\": SYNC is the drive's "
                         "clock"};
    }
    if (robot.jitter_ms >= 0.5 * period_ms) {
        return rig_error{"robot.jitter_ms", "must be less than half a period, so that setpoints keep their order"};
    }
    if (robot.clock == robot_clock::free && robot.clock_phase_ms >= period_ms) {
        return rig_error{"robot.clock_phase_ms", "must be less than a period"};
    }
    if (!(std::abs(robot.clock_drift_ppm) <= 1e5)) {
        return rig_error{"robot.clock_drift_ppm", "must be within +-100000 ppm"};
    }
    return {};
}

std::optional<rig_error> check_sensor(const rig &rig)
{
    const sensor_rig &sensor = rig.sensor;
    if (sensor.low_pass_order > 2) {
        return rig_error{"sensor.low_pass_order", "must be 0, 1 or 2"};
    }
    const auto frames = std::int64_t{sensor_layouts[rig.firmware.sensor_channel.layout].frame_count};
    const std::int64_t sample_ns = config_sample_period_ns(&rig.firmware);
    if (ns_from_ms(sensor.delay_ms) < frames * frame_time_ns(rig.bus, 8)) {
        char text[200];
        std::snprintf(
            text, sizeof text,
            "is shorter than the sample's time on the bus, which it includes (is %g ms, the bus takes %.3g "
            "ms); give it in milliseconds, or set bus.ideal = true",
            sensor.delay_ms, 1e-6 * static_cast<double>(frames * frame_time_ns(rig.bus, 8)));
        return rig_error{"sensor.delay_ms", text};
    }
    const sensor_channel_config &channel = rig.firmware.sensor_channel;
    if (!sensor_layout_is_numbered(&sensor_layouts[channel.layout]) &&
        ns_from_ms(channel.pairing_window_ms) < (frames - 1) * frame_time_ns(rig.bus, 8)) {
        return rig_error{"sensor_channel.pairing_window_ms",
                         "is shorter than the frames of a sample take on the bus, so that no sample would be whole; "
                         "make it longer, at most half of the time between two samples"};
    }
    if (sample_ns < frames * frame_time_ns(rig.bus, 8)) {
        return rig_error{"sensor.rate_Hz", "is too fast for the bus: the frames of its samples would queue up"};
    }
    const std::int64_t samples_a_tick = (config_period_ns(&rig.firmware) + sample_ns - 1) / sample_ns;
    if (samples_a_tick * frames > TICK_SENSOR_FRAMES_MAX) {
        return rig_error{"sensor.rate_Hz", "is too fast for the loop, which takes at most " +
                                               std::to_string(TICK_SENSOR_FRAMES_MAX) +
                                               " frames of the sensor a tick"};
    }
    if (sensor.delay_ms > 1e5) {
        return rig_error{"sensor.delay_ms", "must be at most 100000 ms"};
    }
    if (sensor.sample_phase_ms >= 1e3 * config_period_s(&rig.firmware)) {
        return rig_error{"sensor.sample_phase_ms", "must be less than a period"};
    }
    return {};
}

/* Beyond these a rig is a slip of the keyboard, and the numbers of its equations lose their digits. */
std::optional<rig_error> check_sizes(const rig &rig)
{
    struct size {
        const char *key;
        double value;
        double low;
        double high;
    };
    const manipulator_config &arm = rig.firmware.manipulator;
    const size sizes[] = {
        {"manipulator.mass_kg", arm.mass_kg, 1e-6, 1e9},
        {"manipulator.stiffness_N_per_m", arm.stiffness_N_per_m, 0.0, 1e13},
        {"manipulator.damping_N_s_per_m", arm.damping_N_s_per_m, 0.0, 1e12},
        {"object.mass_kg", rig.object.mass_kg, 1e-6, 1e9},
        {"object.stiffness_N_per_m", rig.object.stiffness_N_per_m, 0.0, 1e13},
        {"object.damping_N_s_per_m", rig.object.damping_N_s_per_m, 0.0, 1e12},
        {"sensor.stiffness_N_per_m", rig.sensor.stiffness_N_per_m, 1e-6, 1e13},
        {"sensor.damping_ratio", rig.sensor.damping_ratio, 0.0, 1e4},
        {"sensor.low_pass_frequency_Hz", rig.sensor.low_pass_frequency_Hz, 1e-6, 1e6},
        {"robot.transfer_frequency_Hz", rig.has_transfer_behaviour() ? rig.robot.transfer_frequency_Hz : 1.0, 1e-6,
         1e6},
        {"robot.transfer_damping_ratio", rig.robot.transfer_damping_ratio, 0.0, 1e4},
    };
    for (const size &one : sizes) {
        if (one.value < one.low || one.value > one.high) {
            char text[120];
            std::snprintf(text, sizeof text, "must be from %g to %g (is %g)", one.low, one.high, one.value);
            return rig_error{one.key, text};
        }
    }
    return {};
}

/* What is wrong with a start beyond the limits: mostly millimetres. */
std::string start_text(const rig &rig, std::string_view key)
{
    if (key != "manipulator.initial_position_m") {
        return "";
    }
    const double start_m = rig.firmware.manipulator.initial_position_m;
    char text[160];
    std::snprintf(text, sizeof text, " (is %g m, they are %g and %g m); positions are in metres: 5 mm are 0.005",
                  start_m, rig.firmware.limits.position_min_m, rig.firmware.limits.position_max_m);
    return text;
}

std::optional<rig_error> check_target(const rig &rig)
{
    if (rig.target.robot_interface.empty() || rig.target.robot_interface.size() >= interface_bytes) {
        return rig_error{"target.robot_interface", "must be the name of a CAN interface, as can0"};
    }
    if (rig.target.sensor_interface.empty() || rig.target.sensor_interface.size() >= interface_bytes) {
        return rig_error{"target.sensor_interface", "must be the name of a CAN interface, as can1"};
    }
    if (rig.target.priority > 98) {
        return rig_error{"target.priority", "must be from 1 to 98: 99 is the kernel's own"};
    }
    return {};
}

std::optional<rig_error> check_others(const rig &rig)
{
    const double ticks = rig.run.duration_s * rig.firmware.loop.rate_Hz;
    if (ticks > 1e10) {
        return rig_error{"run.duration_s", "gives more than 1e10 ticks"};
    }
    if (rig.object.kind == object_kind::contact && rig.run.grip_release_s < never) {
        return rig_error{"run.grip_release_s", "needs a gripped object: a tool in contact has nothing to let go"};
    }
    if (rig.object.kind == object_kind::contact && rig.run.grip_close_s > 0.0) {
        return rig_error{"run.grip_close_s", "needs a gripped object: a tool in contact grips nothing"};
    }
    if (touches_nothing(rig) && (rig.run.grip_close_s > 0.0 || rig.run.grip_release_s < never)) {
        return rig_error{"run.grip_close_s", "needs an object: object.kind = \"none\" has nothing to grip"};
    }
    if (touches_nothing(rig) && rig.has_side_axes()) {
        return rig_error{"object.kind", "must not be \"none\" with [axis.*]: each has an object of its own"};
    }
    if (touches_nothing(rig) && (rig.firmware.prediction.enabled != 0 || rig.firmware.force_lead.enabled != 0)) {
        return rig_error{"object.kind", "is \"none\", so that there is no force to predict or to lead: leave "
                                        "prediction and force lead out"};
    }
    if (rig.run.grip_close_s > 0.0 && rig.run.grip_release_s <= rig.run.grip_close_s) {
        return rig_error{"run.grip_release_s", "must be later than run.grip_close_s"};
    }
    const double shortest_ms = 2e3 * config_period_s(&rig.firmware);
    if (rig.run.dead_time_jump_s < never && rig.robot.dead_time_ms + rig.run.dead_time_jump_ms < shortest_ms) {
        return rig_error{"run.dead_time_jump_ms", "must leave the robot a dead time of 2 periods or more"};
    }
    if (rig.profile.kind == profile_kind::file && rig.profile.file.empty()) {
        return rig_error{"profile.file", "is missing: profile.kind = \"file\" needs it"};
    }
    if (rig.bus.error_probability > 0.9) {
        return rig_error{"bus.error_probability",
                         "must be at most 0.9: a destroyed frame is sent again until it passes"};
    }
    if (rig.bus.burst_length_frames < 1.0) {
        return rig_error{"bus.burst_length_frames", "must be 1 or more"};
    }
    if (rig.solver.contact_step_us < 0.01) {
        return rig_error{"solver.contact_step_us", "must be 0.01 or more"};
    }
    if (rig.object.kind == object_kind::contact &&
        rig.firmware.manipulator.initial_position_m > rig.object.surface_position_m) {
        return rig_error{"manipulator.initial_position_m",
                         "must not lie beyond object.surface_position_m: the run starts without contact"};
    }
    return {};
}

std::optional<rig_error> check_arm(const rig &rig)
{
    const manipulator_config &manipulator = rig.firmware.manipulator;
    const arm_config &arm = rig.firmware.arm;
    if (arm.kind == ARM_NONE) {
        return {};
    }
    const bool is_planar = arm.kind == ARM_PLANAR;
    if (manipulator.direction_x == 0.0 && manipulator.direction_y == 0.0 &&
        (is_planar || manipulator.direction_z == 0.0)) {
        return rig_error{"manipulator.direction_x",
                         is_planar ? "must not be 0 together with direction_y: it is no direction"
                                   : "must not be 0 together with direction_y and direction_z"};
    }
    for (const auto &[key, part] : {std::pair("manipulator.direction_x", manipulator.direction_x),
                                    std::pair("manipulator.direction_y", manipulator.direction_y),
                                    std::pair("manipulator.direction_z", manipulator.direction_z)}) {
        if (part != 0.0 && !(std::abs(part) >= 1e-12 && std::abs(part) <= 1e12)) {
            return rig_error{key, "must be 0, or of a size from 1e-12 to 1e12: only the direction counts"};
        }
    }
    if (is_planar && manipulator.direction_z != 0.0) {
        return rig_error{"manipulator.direction_z", "must be 0: the arm is planar"};
    }
    if (manipulator.initial_velocity_m_per_s != 0.0) {
        return rig_error{"manipulator.initial_velocity_m_per_s", "must be 0: an arm starts at rest"};
    }
    if (rig.firmware.prediction.enabled != 0) {
        return rig_error{"prediction.enabled", "predicts with a manipulator of one degree of freedom: an arm on its "
                                               "satellite goes unstable with it; use extrapolation or force_lead"};
    }
    if (arm.joint_count < (is_planar ? 2 : 3)) {
        return rig_error{"manipulator.arm", is_planar
                                                ? "needs two joints at least, or its tool cannot be led in the "
                                                  "plane"
                                                : "needs three joints at least, or its tool cannot be led in "
                                                  "every direction"};
    }
    if (arm_start_dexterity(&arm) < 1.0) {
        return rig_error{"manipulator.arm",
                         "starts at or near a singular pose, where its tool cannot be led in every "
                         "direction; change initial_rad of its joints"};
    }
    std::size_t place = 0;
    for (const effect_key &key : effect_keys()) {
        if (rig.effect_values[place++] != 0.0 && key.path.substr(0, 12) == "manipulator.") {
            return rig_error{std::string(key.path),
                             "is an effect of a manipulator of one degree of freedom; it cannot "
                             "be put into an arm"};
        }
    }
    return {};
}

std::optional<rig_error> check_effects(const rig &rig)
{
    std::size_t place = 0; /* effect_values has them in this order */
    for (const effect_key &key : effect_keys()) {
        if (rig.object.further_mode_count > 0 && rig.effect_values[place] != 0.0 &&
            key.path.substr(0, 7) == "object.") {
            return rig_error{std::string(key.path),
                             "is an effect of an object of one degree of freedom; it cannot be "
                             "put into a beam of several modes, see object.modes"};
        }
        const double value = rig.effect_values[place++];
        if (value != 0.0 && rig.object.kind == object_kind::contact &&
            key.path == "object.relaxation_stiffness_N_per_m") {
            return rig_error{std::string(key.path),
                             "is an effect of a gripped object; this one is touched from one side, see object.kind"};
        }
        if (value != 0.0 && rig.sensor.low_pass_order != 2 && key.path == "sensor.tool_mass_kg") {
            return rig_error{std::string(key.path), "needs sensor.low_pass_order = 2: nothing else smooths the "
                                                    "acceleration of a robot that goes straight between setpoints"};
        }
        if (value == 0.0 && !key.needed_with.empty()) {
            const rig_key &size = *find_key(key.needed_with);
            if (rig.effect_values[size.effect_value] != 0.0) {
                return rig_error{std::string(key.path), "is missing: " + std::string(key.needed_with) +
                                                            " is not 0 and needs it (" + std::string(key.meaning) +
                                                            ")"};
            }
        }
    }
    return {};
}

} // namespace

double rig::sensor_damping_N_s_per_m() const
{
    return 2.0 * sensor.damping_ratio * std::sqrt(sensor.stiffness_N_per_m * object.mass_kg);
}

std::int64_t rig::sample_age_ns() const
{
    const std::int64_t sample_period_ns = config_sample_period_ns(&firmware);
    const std::int64_t phase_ns = ns_from_ms(sensor.sample_phase_ms);
    const std::int64_t delay_ns = ns_from_ms(sensor.delay_ms);
    if (has_wandering_samples()) {
        return delay_ns + sample_period_ns / 2;
    }
    return (phase_ns + delay_ns + sample_period_ns - 1) / sample_period_ns * sample_period_ns - phase_ns;
}

double rig::sensor_low_pass_delay_s() const
{
    const double w = 2.0 * M_PI * sensor.low_pass_frequency_Hz;
    return sensor.low_pass_order == 2   ? 2.0 * sensor.low_pass_damping_ratio / w
           : sensor.low_pass_order == 1 ? 1.0 / w
                                        : 0.0;
}

bool rig::has_side_axes() const
{
    return std::any_of(std::begin(firmware.side_axes), std::end(firmware.side_axes),
                       [](const side_axis_config &axis) { return axis.enabled != 0; });
}

std::optional<double> rig::tolerance_of(std::string_view key) const
{
    const auto found =
        std::find_if(tolerances.begin(), tolerances.end(), [&](const tolerance &known) { return known.key == key; });
    return found == tolerances.end() ? std::optional<double>() : found->share;
}

std::optional<rig_error> complete_and_check(rig &rig)
{
    rig.firmware.inverse_filter.robot_frequency_Hz =
        rig.has_transfer_behaviour() ? rig.robot.transfer_frequency_Hz : 0.0;
    rig.firmware.inverse_filter.robot_damping_ratio = rig.robot.transfer_damping_ratio;

    rig.firmware.sensor_channel.rate_Hz = rig.sensor.rate_Hz;
    rig.firmware.tare = tare_of(rig);
    if (auto found = complete_and_check_axes(rig)) {
        return found;
    }

    const config_error error = config_validate(&rig.firmware);
    if (error.key != nullptr) {
        const bool is_rate = std::string(error.key) == "loop.rate_Hz" && rig.firmware.loop.rate_Hz >= 1.0 &&
                             rig.firmware.loop.rate_Hz <= 1e6;
        return rig_error{error.key,
                         error.message + (is_rate ? near_rates(rig.firmware) : start_text(rig, error.key))};
    }
    if (auto beam_error = complete_beam(rig)) {
        return beam_error;
    }
    for (const auto check : {check_sizes, check_bus, check_robot, check_sensor, check_target, check_others,
                             check_arm, check_orders, check_effects}) {
        if (auto found = check(rig)) {
            return found;
        }
    }
    rig.firmware.energy.force_age_ms =
        1e-6 * static_cast<double>(rig.sample_age_ns()) + 1e3 * rig.sensor_low_pass_delay_s();
    rig.firmware.hardware = hardware_model_of(rig);
    const config_error compensation_error = compensation_validate(&rig.firmware);
    if (compensation_error.key != nullptr) {
        return rig_error{compensation_error.key, compensation_error.message};
    }
    return {};
}

std::int64_t event_ns(double time_s)
{
    return time_s < 1e9 ? ns_from_ms(1e3 * time_s) : std::numeric_limits<std::int64_t>::max();
}

std::int64_t sync_wait_ns(const rig &rig)
{
    return rig.firmware.robot_channel.profile == ROBOT_PROFILE_CIA402 ? config_period_ns(&rig.firmware) : 0;
}

std::int64_t command_to_motion_ns(const rig &rig)
{
    return ns_from_ms(rig.robot.dead_time_ms) + sync_wait_ns(rig);
}

std::int64_t least_dead_time_ns(const rig &rig)
{
    return rig.robot.interpolation == interpolation::linear ? config_period_ns(&rig.firmware)
                                                            : robot_frames_a_tick(rig) * frame_time_ns(rig.bus, 8);
}

std::int64_t robot_frames_a_tick(const rig &rig)
{
    const auto sides = std::count_if(std::begin(rig.firmware.side_axes), std::end(rig.firmware.side_axes),
                                     [](const side_axis_config &axis) { return axis.enabled != 0; });
    return rig.firmware.robot_channel.profile == ROBOT_PROFILE_CIA402 ? 4 : 3 + 2 * sides;
}

std::int64_t frame_time_ns(const bus_rig &bus, int data_bytes)
{
    if (bus.ideal) {
        return 0;
    }
    /* Base frame: 34 bits that can be stuffed and 13 that cannot (delimiters, ACK, end, 3 bits interframe space);
     * at worst one stuff bit after the first 5 bits and after every 4 more. */
    const int stuffable_bits = 34 + 8 * data_bytes;
    const int bits = stuffable_bits + 13 + (stuffable_bits - 1) / 4;
    return std::llround(1e9 * bits / bus.bit_rate_bit_per_s);
}

} // namespace berth
