#include "plausibility.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../firmware/pi.h"
#include "../firmware/sensor_layout.h"
#include "../hal/rig/rig_file.h"
#include "delay_budget.h"
#include "effects/effect.h"

namespace berth
{

namespace
{

/* Up to here a position-controlled industrial robot follows without a large error: the wall of Krenn & Schäfer's
 * maps, as `berth map` draws it. */
constexpr double robot_follows_Hz = 5.0;

/* Catalogues of six-axis force sensors of 10 N to 100 kN list 1e5 to 1e9 N/m. */
constexpr double sensor_softest_N_per_m = 1e5;
constexpr double sensor_stiffest_N_per_m = 1e9;

/* A sensor that gives way more than a tenth as far as the object shows another object. */
constexpr double sensor_to_object_least = 10.0;

/* Of the shipped presets, a Yaskawa DX200; twice that is no robot that closes a loop. */
constexpr double slowest_preset_ms = 250.0;
constexpr double dead_time_longest_ms = 2.0 * slowest_preset_ms;

/* Ticks in a period of the coupled swing: below 20 the hold alone costs 9 degrees of phase. */
constexpr double ticks_per_period_least = 20.0;

/* A second-order low-pass at twice the swing's frequency still turns its phase by 43 degrees. */
constexpr double low_pass_to_swing_least = 2.0;

/* Calibrated sensors state 0.5 % to 5 %; half is no calibration. */
constexpr double gain_error_largest = 0.5;

/* Joints and structures in space: 0.001 to 0.2 are published. */
constexpr double damping_ratio_largest = 1.0;

constexpr double mass_ratio_largest = 100.0;

/* Limits below half of what the first swing needs act in most of its ticks. */
constexpr double limit_to_swing_least = 0.5;

/* Times the force: then it drives the loop, and its unit is most likely wrong. A choice; a light object on a coarse
 * sensor may have 8. */
constexpr double noise_to_force_largest = 10.0;

std::string in_short(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

double swing_frequency_Hz(double stiffness_N_per_m, double mass_kg)
{
    return std::sqrt(stiffness_N_per_m / mass_kg) / (2.0 * pi);
}

class value_checks
{
  public:
    explicit value_checks(const rig &of) : rig_(of) {}

    std::vector<implausible_value> all()
    {
        check_frequencies();
        check_sensor();
        check_range();
        check_gain();
        check_dead_time();
        check_delay();
        check_damping();
        check_masses();
        check_start();
        check_grip();
        check_limits();
        check_noise();
        return std::move(found_);
    }

  private:
    void add(const char *key, std::string what, std::string why, std::string advice)
    {
        found_.push_back({key, std::move(what), std::move(why), std::move(advice)});
    }

    bool has_arm() const { return rig_.firmware.arm.kind != ARM_NONE; }

    /* Of manipulator and object together; of a tool in contact as well. */
    double swing_Hz() const
    {
        return swing_frequency_Hz(rig_.firmware.manipulator.stiffness_N_per_m + rig_.object.stiffness_N_per_m,
                                  rig_.firmware.manipulator.mass_kg + rig_.object.mass_kg);
    }

    void check_frequencies()
    {
        if (touches_nothing(rig_)) {
            return;
        }
        const double swing = swing_Hz();
        const bool is_object = rig_.object.stiffness_N_per_m >= rig_.firmware.manipulator.stiffness_N_per_m;
        const char *const key = is_object ? "object.stiffness_N_per_m" : "manipulator.stiffness_N_per_m";
        const double stiffness =
            is_object ? rig_.object.stiffness_N_per_m : rig_.firmware.manipulator.stiffness_N_per_m;
        if (swing > robot_follows_Hz) {
            add(key, in_short(stiffness) + " N/m makes manipulator and object swing at " + in_short(swing) + " Hz",
                "an industrial robot follows up to about " + in_short(robot_follows_Hz) +
                    " Hz: beyond it, its amplitude and phase are its own, and not the model's",
                "check the unit (N/mm?); stiffness or mass must give a swing below " + in_short(robot_follows_Hz) +
                    " Hz");
        }
        const double ticks = rig_.firmware.loop.rate_Hz / swing;
        if (ticks < ticks_per_period_least) {
            add("loop.rate_Hz",
                in_short(rig_.firmware.loop.rate_Hz) + " Hz gives " + in_short(ticks) +
                    " ticks in a period of the swing at " + in_short(swing) + " Hz",
                "below " + in_short(ticks_per_period_least) + " ticks the held force alone costs 9 degrees of phase",
                "raise loop.rate_Hz, or lower the stiffness");
        }
        if (rig_.sensor.low_pass_order > 0 && rig_.sensor.low_pass_frequency_Hz < low_pass_to_swing_least * swing) {
            add("sensor.low_pass_frequency_Hz",
                in_short(rig_.sensor.low_pass_frequency_Hz) + " Hz is near the swing at " + in_short(swing) + " Hz",
                "a low-pass below " + in_short(low_pass_to_swing_least) +
                    " times the swing's frequency turns the force's phase by tens of degrees",
                "raise it, or set sensor.low_pass_order = 0");
        }
    }

    void check_sensor()
    {
        const double stiffness = rig_.sensor.stiffness_N_per_m;
        if (stiffness < sensor_softest_N_per_m || stiffness > sensor_stiffest_N_per_m) {
            add("sensor.stiffness_N_per_m", "is " + in_short(stiffness) + " N/m",
                "catalogues list force sensors from " + in_short(sensor_softest_N_per_m) + " to " +
                    in_short(sensor_stiffest_N_per_m) + " N/m",
                "check the unit (N/mm, N/um?)");
        }
        if (!touches_nothing(rig_) && stiffness < sensor_to_object_least * rig_.object.stiffness_N_per_m) {
            add("sensor.stiffness_N_per_m",
                in_short(stiffness) + " N/m beside an object of " + in_short(rig_.object.stiffness_N_per_m) + " N/m",
                "a sensor less than " + in_short(sensor_to_object_least) +
                    " times as stiff as the object gives way instead of the object",
                "check both; a stiffer sensor shows the object");
        }
    }

    void check_gain()
    {
        const double gain_error = value_of(rig_, "sensor.gain_error");
        if (std::abs(gain_error) > gain_error_largest) {
            add("sensor.gain_error", "is " + in_short(gain_error),
                "calibrated force sensors are within a few percent; beyond " + in_short(gain_error_largest) +
                    " the loop feels another object than the one that it touches",
                "it is a share: 0.01 is 1 %; check sign and unit");
        }
    }

    /* The key that makes most of the loop's delay. */
    std::pair<const char *, double> longest_part(const delay_budget &budget) const
    {
        const double robot_lag_ms = value_of(rig_, "robot.lag_ms");
        const double sensor_lag_ms = value_of(rig_, "sensor.lag_ms");
        const std::pair<const char *, double> parts[] = {
            {"robot.dead_time_ms", rig_.robot.dead_time_ms},
            {"robot.lag_ms", robot_lag_ms},
            {"robot.transfer_frequency_Hz", budget.robot_ms - rig_.robot.dead_time_ms - robot_lag_ms},
            {"loop.rate_Hz", budget.hold_ms},
            {"sensor.delay_ms", rig_.sensor.delay_ms},
            {"sensor.lag_ms", sensor_lag_ms},
            {"sensor.low_pass_frequency_Hz", budget.low_pass_ms},
            {rig_.sensor.rate_Hz > 0.0 ? "sensor.rate_Hz" : "loop.rate_Hz", budget.wait_ms}};
        return *std::max_element(std::begin(parts), std::end(parts),
                                 [](const auto &a, const auto &b) { return a.second < b.second; });
    }

    /* Of the whole loop, whichever part it is that lags. */
    void check_delay()
    {
        const delay_budget budget = delay_budget_of(rig_);
        if (budget.total_ms() <= dead_time_longest_ms || rig_.robot.dead_time_ms > dead_time_longest_ms) {
            return;
        }
        const auto [key, part_ms] = longest_part(budget);
        add(key, "makes " + in_short(part_ms) + " ms of a loop's delay of " + in_short(budget.total_ms()) + " ms",
            "a force that is " + in_short(dead_time_longest_ms) + " ms old tells of another motion",
            "check the unit (us?)");
    }

    void check_dead_time()
    {
        if (rig_.robot.dead_time_ms > dead_time_longest_ms) {
            add("robot.dead_time_ms", "is " + in_short(rig_.robot.dead_time_ms) + " ms",
                "the slowest robot of the shipped presets has " + in_short(slowest_preset_ms) + " ms; more than " +
                    in_short(dead_time_longest_ms) + " ms is no robot that closes a loop",
                "check the unit (us?); `berth robots` lists what is reported");
        }
    }

    void check_ratio(const char *key, double damping_N_s_per_m, double stiffness_N_per_m, double mass_kg)
    {
        if (stiffness_N_per_m <= 0.0) {
            return;
        }
        const double ratio = damping_N_s_per_m / (2.0 * std::sqrt(stiffness_N_per_m * mass_kg));
        if (ratio > damping_ratio_largest) {
            add(key, in_short(damping_N_s_per_m) + " N s/m is a damping ratio of " + in_short(ratio),
                "joints and structures have 0.001 to 0.2; beyond 1 nothing swings",
                "check the unit, or whether it is a damping ratio; a damper of 5 % is " +
                    in_short(0.1 * std::sqrt(stiffness_N_per_m * mass_kg)) + " N s/m");
        }
        if (damping_N_s_per_m == 0.0) {
            add(key, "is 0", "every joint and structure has some damping, and the verdict hangs on it",
                "a damper of 1 % is " + in_short(0.02 * std::sqrt(stiffness_N_per_m * mass_kg)) + " N s/m");
        }
    }

    /* A tool in contact has a mass of its own beside a damped material: no structure. */
    void check_damping()
    {
        const manipulator_config &manipulator = rig_.firmware.manipulator;
        if (!has_arm()) {
            check_ratio("manipulator.damping_N_s_per_m", manipulator.damping_N_s_per_m,
                        manipulator.stiffness_N_per_m, manipulator.mass_kg);
        }
        if (rig_.object.kind == object_kind::gripped) {
            check_ratio("object.damping_N_s_per_m", rig_.object.damping_N_s_per_m, rig_.object.stiffness_N_per_m,
                        rig_.object.mass_kg);
        }
    }

    void check_masses()
    {
        const double ratio = rig_.object.mass_kg / rig_.firmware.manipulator.mass_kg;
        if (!touches_nothing(rig_) && ratio > mass_ratio_largest) {
            add("object.mass_kg",
                in_short(rig_.object.mass_kg) + " kg is " + in_short(ratio) + " times the manipulator's",
                "beyond " + in_short(mass_ratio_largest) + " times, the simulated manipulator hardly counts",
                "check both units (g?)");
        }
    }

    void check_range()
    {
        const sensor_channel_config &channel = rig_.firmware.sensor_channel;
        const double range_N = sensor_layouts[channel.layout].force_max_N;
        if (channel.force_limit_N > range_N) {
            add("sensor_channel.force_limit_N", in_short(channel.force_limit_N) + " N",
                "the frames of sensor_channel.layout hold " + in_short(range_N) +
                    " N: a larger force saturates them before the limit acts",
                "choose a lower limit, or a layout with a wider range");
        }
    }

    void check_start()
    {
        const double force_N =
            std::abs(rig_.firmware.manipulator.initial_position_m) * rig_.object.stiffness_N_per_m;
        const double limit_N = rig_.firmware.sensor_channel.force_limit_N;
        if (rig_.object.kind == object_kind::gripped && force_N > limit_N) {
            add("manipulator.initial_position_m",
                "stretches the object with " + in_short(force_N) + " N at the start",
                "the loop stops beyond sensor_channel.force_limit_N, " + in_short(limit_N) + " N",
                "start nearer to 0, or raise the limit");
        }
    }

    void check_grip()
    {
        if (never_grips(rig_)) {
            add("run.grip_close_s",
                in_short(rig_.run.grip_close_s) + " s is not before the run's end, " +
                    in_short(rig_.run.duration_s) + " s",
                "the run never grips the object, so that it never closes the loop",
                "let run.grip_close_s lie within the run");
        }
    }

    /* A gripped object, let go from rest, swings as far as it was deflected. */
    bool swings_by_itself() const { return rig_.object.kind == object_kind::gripped && !has_arm(); }

    void check_limit(const char *key, double limit, double needed, const std::string &unit)
    {
        if (limit < limit_to_swing_least * needed) {
            add(key,
                in_short(limit) + " " + unit + ", and the swing from the start needs " + in_short(needed) + " " +
                    unit,
                "below " + in_short(limit_to_swing_least) +
                    " of that the robot shows the limit's motion, not the "
                    "simulated one",
                "check the unit (mm?), raise the limit, or start from less (manipulator.initial_position_m)");
        }
    }

    void check_limits()
    {
        if (!swings_by_itself()) {
            return;
        }
        const double omega_per_s = 2.0 * pi * swing_Hz();
        const double velocity_m_per_s = omega_per_s * std::abs(rig_.firmware.manipulator.initial_position_m);
        const limits_config &limits = rig_.firmware.limits;
        check_limit("limits.velocity_m_per_s", limits.velocity_m_per_s, velocity_m_per_s, "m/s");
        check_limit("limits.acceleration_m_per_s2", limits.acceleration_m_per_s2, omega_per_s * velocity_m_per_s,
                    "m/s2");
    }

    void check_noise()
    {
        const double way_m =
            std::abs(rig_.firmware.manipulator.initial_position_m) + std::abs(rig_.profile.amplitude_m);
        const double force_N = rig_.object.stiffness_N_per_m * way_m;
        if (swings_by_itself() && force_N > 0.0 && rig_.sensor.noise_N > noise_to_force_largest * force_N) {
            add("sensor.noise_N",
                "is " + in_short(rig_.sensor.noise_N) + " N beside a force of about " + in_short(force_N) + " N",
                "noise of more than " + in_short(noise_to_force_largest) +
                    " times the force drives the loop, and the "
                    "object does not",
                "it is a standard deviation in N: check the unit (mN?)");
        }
    }

    const rig &rig_;
    std::vector<implausible_value> found_;
};

} // namespace

bool never_grips(const rig &rig)
{
    return rig.run.grip_close_s < never && rig.run.grip_close_s >= rig.run.duration_s;
}

std::vector<implausible_value> implausible_values(const rig &rig)
{
    return value_checks(rig).all();
}

} // namespace berth
