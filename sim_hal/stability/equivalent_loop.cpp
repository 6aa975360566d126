#include "equivalent_loop.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../../firmware/pi.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"
#include "../effects/velocity_follower.h"
#include "../plant/plant.h"
#include "critical_zero.h"
#include "loop_timeline.h"

namespace berth
{

namespace
{

using complex = std::complex<double>;

bool is_of_size(const effect &effect)
{
    return effect.when_small == small_motion::depends_on_size || effect.when_small == small_motion::higher_order;
}

bool limits_setpoints(const rig &rig)
{
    return rig.robot.acceleration_limit_m_per_s2 != unlimited;
}

bool shapes_samples(const rig &rig)
{
    return rig.sensor.resolution_N > 0.0 || rig.sensor.saturation_N != unlimited ||
           value_of_effect(rig, "sensor.curvature_per_N") != 0.0;
}

/* Where the robot pulls with such a force, on top of its mean. */
bool lets_go(const rig &rig, double pull_N)
{
    constexpr double surely_held = 0.7;
    const double grip_N = value_of_effect(rig, "object.grip_force_N");
    return rig.object.kind == object_kind::contact || (grip_N > 0.0 && pull_N > surely_held * grip_N);
}

/* Where the operator holds the manipulator's spring in the end. */
double operator_position_m(const rig &rig)
{
    const bool ends_elsewhere = rig.profile.kind == profile_kind::step || rig.profile.kind == profile_kind::ramp ||
                                rig.profile.kind == profile_kind::minimum_jerk;
    return rig.profile.offset_m + (ends_elsewhere ? rig.profile.amplitude_m : 0.0);
}

rig without_effects_of_size(const rig &original)
{
    rig made = original;
    for (const effect &known : effect_library()) {
        if (is_of_size(known) && is_active(known, original)) {
            for (const effect_parameter &parameter : known.parameters) {
                if (!parameter.meaning.empty()) {
                    set_number(made, parameter.key, 0.0);
                }
            }
        }
    }
    if (saturates_in_lag(original)) {
        set_number(made, "robot.lag_ms", 0.0);
    }
    made.robot.velocity_limit_m_per_s = made.robot.acceleration_limit_m_per_s2 = unlimited;
    made.sensor.resolution_N = 0.0;
    made.sensor.saturation_N = unlimited;
    made.object.kind = object_kind::gripped;
    return made;
}

/* One guess at the frequency, and what follows of it; amplitudes and the mean position are found from those before.
 */
class balance_of_harmonics
{
  public:
    balance_of_harmonics(const rig &rig, double amplitude_m)
        : rig_(rig), amplitude_m_(amplitude_m), base_(without_effects_of_size(rig)), plant_(base_),
          mean_m_(operator_position_m(rig))
    {
    }

    /* The linear rig where the mode has this frequency. */
    rig at(double w_rad_per_s)
    {
        w_ = w_rad_per_s;
        s_ = complex(0.0, w_);
        parts.clear();
        lag_rad_ = 0.0;
        rig made = base_;
        const double robot_m = robot_amplitude_m(made);
        const double pull_N = robot_m * std::abs(object_forces(made, robot_m));
        add_manipulator_forces(made);
        add_sample_gain(made, pull_N);
        made.robot.dead_time_ms += 1e3 * lag_rad_ / w_;
        return made;
    }

    std::vector<equivalent_part> parts;

  private:
    void add_signal(std::string what, complex gain)
    {
        lag_rad_ -= std::arg(gain);
        parts.push_back({std::move(what), std::abs(gain), -std::arg(gain) * 360.0 / two_pi, {}});
    }

    /* Setpoint to tool; the gain goes into the rig. */
    double robot_amplitude_m(rig &made)
    {
        double height_m = amplitude_m_;
        double gain = 1.0 + value_of_effect(rig_, "robot.gain_error");
        if (limits_setpoints(rig_) || value_of_effect(rig_, "robot.deadband_m") > 0.0) {
            const complex path = setpoint_gain(rig_, {height_m, 0.0, w_});
            add_signal("robot: limits and dead band", path / gain);
            gain = std::abs(path);
        }
        height_m *= gain;
        if (limits_reference(rig_)) {
            limited_velocity limiter(rig_.robot.velocity_limit_m_per_s);
            const complex through = gain_of(limiter, {height_m, 0.0, w_});
            add_signal("robot.velocity_limit", through);
            height_m *= std::abs(through);
            gain *= std::abs(through);
        }
        if (plant_.has_transfer_behaviour) {
            const double w = plant_.robot_w;
            height_m *= std::abs(w * w / (s_ * s_ + 2.0 * plant_.robot_z * w * s_ + w * w));
        }
        for (const effect &known : effect_library()) {
            if (known.on_motion == nullptr || !is_active(known, rig_)) {
                continue;
            }
            if (!is_of_size(known) && !saturates_in_lag(rig_)) { /* the lag, which the linear rig keeps */
                height_m /= std::abs(1.0 + s_ * plant_.robot_lag_s);
                continue;
            }
            const complex through = gain_of(*known.on_motion(rig_), {height_m, mean_m_, w_});
            add_signal(std::string(known.name), through);
            height_m *= std::abs(through);
            gain *= std::abs(through);
        }
        set_number(made, "robot.gain_error", gain - 1.0);
        return height_m;
    }

    /* What hangs on the sensor's spring, as dynamic stiffness without the object's own spring, damper and mass. */
    complex hanging_stiffness() const
    {
        const complex relaxing =
            plant_.relaxation_N_per_m > 0.0
                ? plant_.relaxation_N_per_m * s_ * plant_.relaxation_s / (1.0 + s_ * plant_.relaxation_s)
                : 0.0;
        if (plant_.second_mass_kg == 0.0) {
            return relaxing;
        }
        const complex link = plant_.second_mass_kg *
                             (plant_.second_w * plant_.second_w + 2.0 * plant_.second_z * plant_.second_w * s_);
        const complex inertia = plant_.second_mass_kg * s_ * s_;
        return relaxing + inertia * link / (inertia + link);
    }

    /* Returns the dynamic stiffness F/r that the robot feels. */
    complex object_forces(rig &made, double robot_m)
    {
        const complex sensor = plant_.sensor_stiffness_N_per_m + s_ * plant_.sensor_damping_N_s_per_m;
        const complex rest = hanging_stiffness() + plant_.mass_kg * s_ * s_;
        object_rig &object = made.object;
        double mean_N = object.stiffness_N_per_m * mean_m_;
        const complex held = object.stiffness_N_per_m + s_ * object.damping_N_s_per_m + rest;
        const double pull_N = robot_m * std::abs(sensor * held / (sensor + held));
        if (lets_go(rig_, pull_N + std::abs(mean_N))) {
            const robot_load load = load_of(rig_, {robot_m, mean_m_, w_});
            const complex alone = 1.0 / (1.0 / load.stiffness_N_per_m - 1.0 / sensor) - rest;
            const spring_and_damper was{object.stiffness_N_per_m, object.damping_N_s_per_m};
            object.stiffness_N_per_m = alone.real();
            object.damping_N_s_per_m = alone.imag() / w_;
            mean_N = load.mean_N;
            parts.push_back({"object: contact and forces",
                             1.0,
                             0.0,
                             {object.stiffness_N_per_m - was.stiffness_N_per_m,
                              object.damping_N_s_per_m - was.damping_N_s_per_m, mean_N}});
        } else {
            const complex own = object.stiffness_N_per_m + object_more_.stiffness_N_per_m +
                                s_ * (object.damping_N_s_per_m + object_more_.damping_N_s_per_m) + rest;
            const double object_m = robot_m * std::abs(sensor / (sensor + own));
            object_more_ = forces_on("object", {object_m, mean_m_, w_}, 0.0, plant_.mass_kg);
            object.stiffness_N_per_m += object_more_.stiffness_N_per_m;
            object.damping_N_s_per_m += object_more_.damping_N_s_per_m;
            mean_N += object_more_.mean_N;
        }
        object_mean_N_ = mean_N;
        const complex own = object.stiffness_N_per_m + s_ * object.damping_N_s_per_m + rest;
        return sensor * own / (sensor + own);
    }

    void add_manipulator_forces(rig &made)
    {
        const manipulator_config &arm = rig_.firmware.manipulator;
        const double rest_m = operator_position_m(rig_);
        const spring_and_damper more = forces_on("manipulator", {amplitude_m_, mean_m_, w_}, rest_m, arm.mass_kg);
        manipulator_config &changed = made.firmware.manipulator;
        changed.stiffness_N_per_m += more.stiffness_N_per_m;
        changed.damping_N_s_per_m += more.damping_N_s_per_m;
        /* Newton's step towards where the mean forces are in balance. */
        const double slope = std::max(0.0, changed.stiffness_N_per_m) + std::max(0.0, made.object.stiffness_N_per_m);
        const double open_N = arm.stiffness_N_per_m * (mean_m_ - rest_m) + more.mean_N + object_mean_N_;
        mean_m_ -= slope > 0.0 ? open_N / slope : 0.0;
    }

    spring_and_damper forces_on(std::string_view block, const sine &position_m, double rest_m, double mass_kg)
    {
        spring_and_damper sum;
        for (const effect &known : effect_library()) {
            if (known.on_body == nullptr || known.block() != block || !is_active(known, rig_) ||
                known.when_small == small_motion::in_the_equations) {
                continue;
            }
            const spring_and_damper force = force_of(*known.on_body(rig_), position_m, rest_m, mass_kg);
            sum.stiffness_N_per_m += force.stiffness_N_per_m;
            sum.damping_N_s_per_m += force.damping_N_s_per_m;
            sum.mean_N += force.mean_N;
            if (is_of_size(known)) {
                parts.push_back({std::string(known.name), 1.0, 0.0, force});
            }
        }
        return sum;
    }

    void add_sample_gain(rig &made, double pull_N)
    {
        if (!shapes_samples(rig_) || pull_N == 0.0) {
            return;
        }
        const double w = plant_.filter_w;
        double height_N = pull_N / std::abs(1.0 + s_ * plant_.sensor_lag_s);
        if (plant_.filter_order == 2) {
            height_N *= std::abs(w * w / (s_ * s_ + 2.0 * plant_.filter_z * w * s_ + w * w));
        } else if (plant_.filter_order == 1) {
            height_N *= std::abs(w / (s_ + w));
        }
        const double slope = 2.0 * value_of_effect(rig_, "sensor.curvature_per_N") * object_mean_N_;
        const double gain = sample_gain(rig_, height_N) * (1.0 + slope);
        parts.push_back({"sensor: quantisation, saturation and curvature",
                         gain / (1.0 + value_of_effect(rig_, "sensor.gain_error")),
                         0.0,
                         {}});
        set_number(made, "sensor.gain_error", gain - 1.0);
    }

    const rig &rig_;
    double amplitude_m_;
    rig base_;
    plant plant_;
    double mean_m_;
    double object_mean_N_ = 0.0;
    spring_and_damper object_more_; /* of the guess before */
    double w_ = 0.0;
    complex s_;
    double lag_rad_ = 0.0;
};

/* A spring that softens to nothing on the way has no equivalent: numbers run away. */
bool is_finite(const rig &rig)
{
    for (const char *const key :
         {"object.stiffness_N_per_m", "object.damping_N_s_per_m", "manipulator.stiffness_N_per_m",
          "manipulator.damping_N_s_per_m", "robot.dead_time_ms", "robot.gain_error", "sensor.gain_error"}) {
        if (!(std::abs(value_of(rig, key)) < 1e15)) {
            return false;
        }
    }
    return true;
}

/* Frequency of manipulator and object together, to start from and for what does not swing. */
double coupled_w(const rig &rig)
{
    const manipulator_config &arm = rig.firmware.manipulator;
    const double w =
        std::sqrt((arm.stiffness_N_per_m + rig.object.stiffness_N_per_m) / (arm.mass_kg + rig.object.mass_kg));
    return w > 0.0 ? w : 1.0;
}

} // namespace

std::vector<std::string> effects_of_size(const rig &rig)
{
    std::vector<std::string> names;
    for (const effect &known : effect_library()) {
        const bool is_there = known.name == "robot.velocity_limit" ? rig.robot.velocity_limit_m_per_s != unlimited
                              : known.name == "robot.acceleration_limit"
                                  ? rig.robot.acceleration_limit_m_per_s2 != unlimited
                              : known.name == "sensor.quantisation" ? rig.sensor.resolution_N > 0.0
                              : known.name == "sensor.saturation"   ? rig.sensor.saturation_N != unlimited
                                                                    : is_of_size(known) && is_active(known, rig);
        if (is_there) {
            names.emplace_back(known.name);
        }
    }
    return names;
}

double usual_amplitude_m(const rig &rig)
{
    constexpr double usual_m = 0.01;
    const bool is_motion = rig.firmware.operator_command.interface == OPERATOR_INTERFACE_MOTION;
    const double of_profile_m = std::abs(rig.profile.amplitude_m);
    return is_motion && rig.profile.kind != profile_kind::rest && of_profile_m > 0.0 ? of_profile_m : usual_m;
}

bool is_slow_to_find(const rig &rig)
{
    return rig.object.kind == object_kind::contact || value_of_effect(rig, "object.grip_force_N") > 0.0 ||
           value_of_effect(rig, "object.quadratic_stiffness_N_per_m2") != 0.0 ||
           value_of_effect(rig, "manipulator.quadratic_stiffness_N_per_m2") != 0.0 ||
           rig.robot.acceleration_limit_m_per_s2 != unlimited || rig.sensor.resolution_N > 0.0;
}

equivalent_loop equivalent_finder::settle(const rig &rig, double w_rad_per_s, follows mode)
{
    const int rounds_max = is_slow_to_find(rig) ? 16 : 80;
    constexpr double same = 1e-7;
    constexpr double settled = 1e-3; /* what lets go does not do the same in every period */
    const double period_s = config_period_s(&rig.firmware);
    balance_of_harmonics balance(rig, amplitude_m_);
    const bool varies = is_time_varying(rig);
    equivalent_loop found{};
    complex before = 0.0;
    for (int i = 0; i < rounds_max; i++) {
        found.linear = balance.at(w_rad_per_s);
        if (!is_finite(found.linear)) {
            constexpr double none = std::numeric_limits<double>::quiet_NaN();
            return {found.linear, none, none, w_rad_per_s / two_pi, balance.parts, false};
        }
        const loop_equation equation = make_loop_equation(varies ? without_variation(found.linear) : found.linear);
        if (mode == follows::largest) {
            roots_.spectral_radius(equation);
            found.z = roots_.dominant_eigenvalue();
        } else {
            found.z = 1.0 / zero_near(equation, std::polar(1.0, -w_rad_per_s * period_s));
        }
        const double w = std::abs(std::arg(found.z)) / period_s;
        found.frequency_Hz = w_rad_per_s / two_pi;
        const double change = std::abs(found.z - before) / std::abs(1.0 - found.z);
        found.has_settled = change < settled;
        if (change < same) {
            break;
        }
        before = found.z;
        if (w * period_s > 1e-6) {
            w_rad_per_s = i < rounds_max / 4 ? w : 0.5 * (w + w_rad_per_s);
        }
    }
    found.growth_per_s = std::log(std::abs(found.z)) / period_s;
    found.parts = balance.parts;
    return found;
}

/* The largest mode changes with the frequency that is guessed: where that goes on for ever, each of the two is asked
 * by itself. */
equivalent_loop equivalent_finder::find(const rig &rig)
{
    const double start = w_rad_per_s_ > 0.0 ? w_rad_per_s_ : coupled_w(rig);
    equivalent_loop found = settle(rig, start, follows::largest);
    if (!found.has_settled && std::isfinite(found.growth_per_s)) {
        const double w = std::abs(std::arg(found.z)) / config_period_s(&rig.firmware);
        for (const double from : {two_pi * found.frequency_Hz, w > 0.0 ? w : start}) {
            equivalent_loop other = settle(rig, from, follows::nearest);
            if (other.has_settled && (!found.has_settled || other.growth_per_s > found.growth_per_s)) {
                found = std::move(other);
            }
        }
    }
    w_rad_per_s_ = found.has_settled ? two_pi * found.frequency_Hz : 0.0;
    return found;
}

std::vector<limit_cycle> limit_cycles(const rig &rig, double amplitude_m)
{
    constexpr double factor_max = 30.0;
    constexpr int steps = 40;
    constexpr double narrow = 1e-6;
    const auto loop_at = [&](double amplitude) { return equivalent_finder(amplitude).find(rig); };
    const auto amplitude_at = [&](int i) {
        return amplitude_m / factor_max * std::pow(factor_max, 2.0 * i / steps);
    };
    std::vector<limit_cycle> cycles;
    double low = amplitude_at(0);
    double low_growth_per_s = loop_at(low).growth_per_s;
    bool low_grows = low_growth_per_s > 0.0;
    for (int i = 1; i <= steps; i++) {
        const double high = amplitude_at(i);
        const double high_growth_per_s = loop_at(high).growth_per_s;
        const bool high_grows = high_growth_per_s > 0.0;
        const bool is_known = std::isfinite(low_growth_per_s) && std::isfinite(high_growth_per_s);
        if (is_known && high_grows != low_grows) {
            double end = high;
            while (end - low > narrow * low) {
                const double middle = std::sqrt(low * end);
                const bool grows = loop_at(middle).growth_per_s > 0.0;
                (grows == low_grows ? low : end) = middle;
            }
            cycles.push_back({low, loop_at(low).frequency_Hz, low_grows});
        }
        low = high;
        low_growth_per_s = high_growth_per_s;
        low_grows = high_grows;
    }
    return cycles;
}

} // namespace berth
