/* The stages in which nothing moves: watch and tare. */
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../../firmware/sensor_layout.h"
#include "judge.h"

namespace berth
{

namespace
{

/* Frames that are lost, rejected or torn: beyond this share of the ticks a bus is not fit for a loop. A bus in order
 * loses none. */
constexpr double trouble_share_max = 0.01;

/* Beyond this, the sensor's rate is not the one in the rig file. */
constexpr double rate_share_max = 0.05;

/* A drift is judged from three times the noise on, and from 0.1 N: below it no loop of these rigs feels it. */
constexpr double drift_times_noise = 3.0;
constexpr double drift_least_N = 0.1;

struct condition_name {
    std::uint32_t bit;
    bool must_be; /* else must not */
    const char *words;
};

constexpr condition_name watched[] = {
    {CONDITION_FEEDBACK_FRESH, true, "the robot's feedback is missing or too old"},
    {CONDITION_SENSOR_FRESH, true, "the force is missing or too old"},
    {CONDITION_OPERATOR_FRESH, true, "the operator's command is missing or too old"},
    {CONDITION_BUS_OFF, false, "a bus is off"},
    {CONDITION_EMERGENCY_STOP, false, "the emergency stop is pressed, or its wire is broken"},
    {CONDITION_ROBOT_FAULT, false, "the robot reports a fault"},
    {CONDITION_SENSOR_SATURATED, false, "the sensor is at the end of its range"},
    {CONDITION_FORCE_LIMIT, false, "the force is beyond sensor_channel.force_limit_N"},
    {CONDITION_MISSED_TICKS, false, "the loop misses too many ticks"},
};

std::string trouble_of(std::uint32_t conditions)
{
    for (const condition_name &one : watched) {
        if (((conditions & one.bit) != 0) != one.must_be) {
            return one.words;
        }
    }
    return {};
}

stage_entry entry_for(stage stage, const std::string &trouble, const std::string &fine)
{
    stage_entry entry;
    entry.stage = stage;
    entry.outcome = trouble.empty() ? stage_outcome::passed : stage_outcome::failed;
    entry.because = trouble.empty() ? fine : trouble;
    return entry;
}

std::string watch_trouble(const rig &told, const stage_run &run, double rate_Hz)
{
    const tick_record &last = run.ticks.back();
    if (run.sent_setpoint) {
        return "a setpoint was sent";
    }
    if (std::string trouble = trouble_of(last.conditions); !trouble.empty()) {
        return trouble;
    }
    const double bad = static_cast<double>(last.lost_frames) + last.rejected_frames + last.torn_samples;
    if (bad > trouble_share_max * static_cast<double>(run.ticks.size())) {
        return "more than one frame in a hundred ticks is lost or rejected";
    }
    const double assumed_Hz = 1e9 / static_cast<double>(config_sample_period_ns(&told.firmware));
    if (std::abs(rate_Hz - assumed_Hz) > rate_share_max * assumed_Hz) {
        return "force samples do not come at the rate of the rig file";
    }
    return {};
}

double mean_lateness_us(const std::vector<tick_record> &ticks)
{
    double sum_ns = 0.0;
    for (const tick_record &tick : ticks) {
        sum_ns += static_cast<double>(tick.woke_ns - tick.scheduled_ns);
    }
    return 1e-3 * sum_ns / static_cast<double>(ticks.size());
}

sensor_axes axes_of(const rig &told)
{
    const sensor_layout_row &layout = sensor_layouts[told.firmware.sensor_channel.layout];
    return layout.axis_count == 1        ? sensor_axes::one
           : layout.torque_max_N_m > 0.0 ? sensor_axes::all
                                         : sensor_axes::forces;
}

constexpr std::array<const char *, 6> axis_words = {"force x",  "force y",  "force z",
                                                    "torque x", "torque y", "torque z"};
constexpr std::array<const char *, 6> tare_keys = {"tare.force_x_N",    "tare.force_y_N",    "tare.force_z_N",
                                                   "tare.torque_x_N_m", "tare.torque_y_N_m", "tare.torque_z_N_m"};
constexpr std::array<const char *, 3> centre_keys = {"tool.centre_x_m", "tool.centre_y_m", "tool.centre_z_m"};

std::size_t axis_count_of(sensor_axes axes)
{
    return axes == sensor_axes::one ? 1 : axes == sensor_axes::forces ? 3 : 6;
}

std::vector<double> axis_of(const stage_run &run, std::size_t axis)
{
    std::vector<double> samples;
    samples.reserve(run.loads.size());
    for (const sensor_load &load : run.loads) {
        samples.push_back(load[axis]);
    }
    return samples;
}

/* The worst of all poses and axes; and the reading of each pose. */
struct tare_reading {
    std::vector<pose_reading> poses;
    double noise_N = 0.0;
    double drift_N_per_s = 0.0;
    double mean_error[6] = {};
    std::string trouble;
};

tare_reading read_poses(const std::vector<tare_pose> &poses, std::size_t axes)
{
    tare_reading reading;
    for (const tare_pose &pose : poses) {
        pose_reading made{pose.gravity_m_per_s2, {}};
        for (std::size_t axis = 0; axis < axes; axis++) {
            const standstill found = standstill_of(axis_of(pose.run, axis), pose.run.load_step_s);
            made.load[axis] = found.mean;
            reading.mean_error[axis] = std::max(reading.mean_error[axis], found.mean_error());
            if (axis >= 3) {
                continue;
            }
            reading.noise_N = std::max(reading.noise_N, found.noise);
            if (std::abs(found.drift_per_s) > std::abs(reading.drift_N_per_s)) {
                reading.drift_N_per_s = found.drift_per_s;
            }
            if (found.drifts(std::max(drift_least_N, drift_times_noise * found.noise))) {
                reading.trouble = "the force drifts; let the sensor warm up, and look for contact";
            }
        }
        if (std::string trouble = trouble_of(pose.run.ticks.back().conditions); !trouble.empty()) {
            reading.trouble = trouble;
        }
        if (pose.run.loads.size() < 100) {
            reading.trouble = "fewer than 100 force samples came";
        }
        reading.poses.push_back(made);
    }
    return reading;
}

/* Half width of the 95 % interval, of the standard error. */
constexpr double sure = 1.96;

void add_zero(stage_entry &entry, const rig &told, const tool_estimate &found, const tare_reading &reading,
              std::size_t axes)
{
    for (std::size_t axis = 0; axis < axes; axis++) {
        const double assumed = axis < 3 ? told.tare.force_N[axis] : told.tare.torque_N_m[axis - 3];
        entry.values.push_back({std::string("zero of ") + axis_words[axis], axis < 3 ? "N" : "N m", found.zero[axis],
                                assumed, sure * reading.mean_error[axis]});
        entry.proposed.emplace_back(tare_keys[axis], found.zero[axis]);
    }
}

void add_tool(stage_entry &entry, const rig &told, const tool_estimate &found)
{
    if (found.mass_is_measured) {
        entry.values.push_back({"mass of the tool", "kg", found.tool.mass_kg, told.tool.mass_kg, {}});
        entry.proposed.emplace_back("tool.mass_kg", found.tool.mass_kg);
    }
    for (std::size_t i = 0; i < 3 && found.centre_is_measured; i++) {
        entry.values.push_back(
            {std::string("centre of the tool ") + "xyz"[i], "m", found.tool.centre_m[i], told.tool.centre_m[i], {}});
        entry.proposed.emplace_back(centre_keys[i], found.tool.centre_m[i]);
    }
}

} // namespace

stage_entry judge_watch(const rig &told, const stage_run &run)
{
    if (run.ticks.empty()) {
        return entry_for(stage::watch, "the loop made no tick", {});
    }
    const double duration_s =
        static_cast<double>(run.ticks.back().index - run.ticks.front().index) * config_period_s(&told.firmware);
    const tick_record &last = run.ticks.back();
    const double rate_Hz = (last.force_samples - run.ticks.front().force_samples) / duration_s;
    stage_entry entry = entry_for(stage::watch, watch_trouble(told, run, rate_Hz),
                                  "robot, sensor and operator are heard, and no setpoint was sent");
    double missed = 0.0;
    for (const tick_record &tick : run.ticks) {
        missed += tick.missed_ticks;
    }
    entry.values = {
        {"force samples", "Hz", rate_Hz, 1e9 / static_cast<double>(config_sample_period_ns(&told.firmware)), {}},
        {"lost frames", "frames", static_cast<double>(last.lost_frames), 0.0, {}},
        {"rejected frames", "frames", static_cast<double>(last.rejected_frames), 0.0, {}},
        {"error frames", "frames", static_cast<double>(last.error_frames), 0.0, {}},
        {"missed ticks", "ticks", missed, 0.0, {}},
        {"mean lateness of the loop", "us", mean_lateness_us(run.ticks), {}, {}},
        {"robot from its start",
         "mm",
         1e3 * (last.robot_position_m - told.firmware.manipulator.initial_position_m),
         0.0,
         {}}};
    return entry;
}

stage_entry judge_tare(const rig &told, const std::vector<tare_pose> &poses)
{
    const sensor_axes axes = axes_of(told);
    const std::size_t count = axis_count_of(axes);
    const tare_reading reading = read_poses(poses, count);
    const tool_estimate found = estimate_tool(reading.poses, axes, told.tool);
    stage_entry entry = entry_for(stage::tare, reading.trouble,
                                  found.mass_is_measured ? "zero and tool are measured, and taken off from now on"
                                                         : "the zero is measured, and taken off from now on; the "
                                                           "tool's mass is that of the rig file");
    add_zero(entry, told, found, reading, count);
    add_tool(entry, told, found);
    entry.values.push_back({"noise of the force", "N", reading.noise_N, told.sensor.noise_N, {}});
    entry.values.push_back({"drift of the force", "N/min", 60.0 * reading.drift_N_per_s, 0.0, {}});
    return entry;
}

} // namespace berth
