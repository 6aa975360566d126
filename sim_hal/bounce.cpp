#include "bounce.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "../firmware/pi.h"
#include "../hal/rig/rig_file.h"
#include "delay_budget.h"
#include "hil/manipulator_stand_in.h"
#include "hil/sim_hal.h"
#include "motion.h"
#include "stability/arm_loop.h"
#include "stability/physical_parameter.h"

namespace berth
{

namespace
{

constexpr double pulled_back_m = 0.01; /* from where the manipulator's own spring sends the tool off */
constexpr double thrown_m_per_s = 0.1; /* where it has none */
constexpr double flight_s = 0.3;       /* of a thrown tool: its shock on the sensor's spring has died down */
constexpr double release_s = 0.05;
constexpr double settled_delays = 3.0; /* of the loop, until the last force has gone from it */

/* A bounce that takes longer is not played: a second of CPU in a search of limits, which plays hundreds. A contact
 * that slow is thousands of delays long, and the eigenvalues in contact say whether it gains. */
constexpr double longest_ticks = 20000.0;
constexpr double longest_s = 10.0; /* or this, if it is more */

double half_period_s(double mass_kg, double stiffness_N_per_m)
{
    return stiffness_N_per_m > 0.0 ? pi * std::sqrt(mass_kg / stiffness_N_per_m) : 0.0;
}

double longest_bounce_s(const rig &rig)
{
    return std::max(longest_s, longest_ticks * config_period_s(&rig.firmware));
}

/* Of the way to the surface, where a spring sends the tool off, or of the stay in the material. */
bool is_too_slow(const rig &rig)
{
    const double moving_kg = rig.firmware.manipulator.mass_kg + rig.object.mass_kg;
    return half_period_s(moving_kg, rig.firmware.manipulator.stiffness_N_per_m) > longest_bounce_s(rig) ||
           half_period_s(moving_kg, rig.object.stiffness_N_per_m) > longest_bounce_s(rig);
}

/* Nothing but the impact: the operator rests at the surface, the bus loses nothing, no limit acts. */
rig impact_of(const rig &original)
{
    rig made = original;
    const manipulator_config &own = original.firmware.manipulator;
    const double surface_m = original.object.surface_position_m;
    const bool has_spring = own.stiffness_N_per_m > 0.0;
    made.firmware.manipulator.initial_position_m =
        surface_m - (has_spring ? pulled_back_m : thrown_m_per_s * flight_s);
    made.firmware.manipulator.initial_velocity_m_per_s = has_spring ? 0.0 : thrown_m_per_s;
    made.firmware.operator_command.interface = OPERATOR_INTERFACE_MOTION;
    made.firmware.limits = {-5.0, 5.0, 100.0, 1e7}; /* what a frame can hold, and no less */
    made.firmware.sensor_channel.force_limit_N = 1e9;
    if (!made.firmware.wrench
             .enabled) { /* a sample arrives at the same time in any layout, and here has the widest range */
        made.firmware.sensor_channel.layout = SENSOR_ONE_FRAME;
    }
    made.profile = {};
    made.profile.offset_m = surface_m;
    made.sensor.noise_N = made.sensor.bias_N = made.sensor.loss_probability = made.sensor.stale_probability = 0.0;
    made.sensor.saturation_N = unlimited;
    made.robot.feedback_noise_m = made.robot.jitter_ms = 0.0;
    made.bus.loss_probability = made.bus.burst_probability = made.bus.error_probability = 0.0;
    made.run = {};
    made.run.release_s = release_s;
    const double moving_kg = own.mass_kg + original.object.mass_kg;
    const double approach_s = has_spring ? half_period_s(moving_kg, own.stiffness_N_per_m) : 2.0 * flight_s;
    const double contact_s = 4.0 * half_period_s(moving_kg, std::max(1.0, original.object.stiffness_N_per_m));
    made.run.duration_s = release_s + approach_s + std::min(contact_s, longest_bounce_s(original)) +
                          2e-2 * delay_budget_of(original).total_ms();
    return made;
}

/* Damped material lets the tool go before that is back at the surface. */
bool pushes(const rig &rig, const rig_truth &now)
{
    const double depth_m = now.object_position_m - rig.object.surface_position_m;
    return depth_m > 0.0 &&
           rig.object.stiffness_N_per_m * depth_m + rig.object.damping_N_s_per_m * now.object_velocity_m_per_s > 0.0;
}

struct hal_closer {
    void operator()(struct hal *hal) const { hal_close(hal); }
};

std::optional<double> energy_at(const rig &original, const rig_key &key, double value)
{
    const auto changed = with_value(original, key, value);
    const auto found = changed ? play_bounce(*changed) : std::nullopt;
    return found ? std::optional<double>(found->restitution - 1.0) : std::nullopt;
}

/* Between two values of which one gains. */
double crossing(const rig &rig, const rig_key &key, double low, double high, bool gains_above)
{
    constexpr double near_enough = 1e-4;
    while (high / low > 1.0 + near_enough) {
        const double middle = std::sqrt(low * high);
        const bool gains = energy_at(rig, key, middle).value_or(0.0) > 0.0;
        (gains == gains_above ? high : low) = middle;
    }
    return std::sqrt(low * high);
}

} // namespace

std::optional<played_bounce> play_bounce(const rig &original)
{
    if (original.object.kind != object_kind::contact) {
        throw input_error("object.kind: a bounce needs a tool in contact, object.kind = \"contact\"");
    }
    refuse_arm(original);
    if (is_too_slow(original)) {
        return {};
    }
    rig made = impact_of(original);
    if (const auto error = complete_and_check(made)) {
        throw input_error(error->key + ": " + error->message);
    }
    const std::unique_ptr<struct hal, hal_closer> hal(sim_open(made));
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &made.firmware);
    manipulator_stand_in manipulator(made);
    const double period_s = config_period_s(&made.firmware);
    const auto settle_ticks =
        1 + static_cast<std::int64_t>(settled_delays * 1e-3 * delay_budget_of(made).total_ms() / period_s);
    std::optional<played_bounce> found;
    std::int64_t touched = -1;
    std::int64_t left = -1;
    while (app->supervisor.state != SUPERVISOR_STOPPED && manipulator.tick(hal.get(), *app)) {
        const tick_record &record = app->recorder.tick;
        const bool touches = record.robot_position_m > made.object.surface_position_m;
        if (app->supervisor.state != SUPERVISOR_RUNNING) {
            continue;
        }
        if (touches && touched < 0) {
            touched = record.index;
            found = played_bounce{0.0, std::abs(speed_at_surface_m_per_s(made, record)), 0.0};
        }
        if (touched >= 0 && left < 0 && pushes(made, sim_rig(hal.get()).truth())) {
            found->contact_s = period_s * static_cast<double>(record.index + 1 - touched);
        }
        if (!touches && touched >= 0 && left < 0) {
            left = record.index;
        }
        if (left >= 0 && record.index >= left + settle_ticks) {
            found->restitution = std::abs(speed_at_surface_m_per_s(made, record)) / found->speed_in_m_per_s;
            break;
        }
    }
    const bool was_stopped =
        left < 0 && app->supervisor.stop_cause != STOP_NONE; /* so that it is not known to stay */
    return was_stopped ? std::nullopt : found;
}

bool comes_to_surface(const rig &original)
{
    rig made = original;
    if (original.firmware.arm.kind == ARM_NONE) { /* an arm at the surface may come to it by noise alone */
        made.sensor.noise_N = made.robot.feedback_noise_m = 0.0;
    }
    const std::unique_ptr<struct hal, hal_closer> hal(sim_open(made));
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &made.firmware);
    manipulator_stand_in manipulator(made);
    while (app->supervisor.state != SUPERVISOR_STOPPED && manipulator.tick(hal.get(), *app)) {
        const bool touches = app->recorder.tick.robot_position_m > made.object.surface_position_m;
        if (touches && app->supervisor.state == SUPERVISOR_RUNNING) {
            return true;
        }
    }
    return false;
}

std::optional<bounce_limit> find_bounce_limit(const rig &rig, std::string_view path)
{
    const rig_key &key = *find_key(path);
    const double own = value_text(rig, key).empty() ? 0.0 : std::stod(value_text(rig, key));
    const bool is_delay = scale_of(path) == parameter_scale::delay;
    const double factor = is_delay ? 10.0 : 1e3;
    const int steps = 24; /* each way */
    const auto own_energy = energy_at(rig, key, own);
    if (!own_energy || !(own > 0.0)) {
        return {};
    }
    const bool gains = *own_energy > 0.0;
    double below = own;
    double above = own;
    for (int i = 1; i <= steps; i++) {
        const double share = std::pow(factor, static_cast<double>(i) / steps);
        const auto up = energy_at(rig, key, own * share);
        if (up && (*up > 0.0) != gains) {
            return bounce_limit{crossing(rig, key, above, own * share, !gains), !gains};
        }
        above = up ? own * share : above;
        const auto down = energy_at(rig, key, own / share);
        if (down && (*down > 0.0) != gains) {
            return bounce_limit{crossing(rig, key, own / share, below, gains), gains};
        }
        below = down ? own / share : below;
    }
    return {};
}

} // namespace berth
