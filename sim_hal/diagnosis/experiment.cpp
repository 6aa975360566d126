#include "experiment.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "../../firmware/loop.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/effect.h"
#include "../hil/manipulator_stand_in.h"
#include "../hil/profile.h"
#include "../hil/sim_hal.h"

namespace berth
{

namespace
{

constexpr double duration_min_s = 10.0;
constexpr double duration_max_s = 30.0;

bool is_force_interface(const rig &rig)
{
    return rig.firmware.operator_command.interface == OPERATOR_INTERFACE_FORCE;
}

/* Largest distance from the mean. */
double excursion_of(const std::vector<double> &x)
{
    double mean = 0.0;
    double largest = 0.0;
    for (const double value : x) {
        mean += value / static_cast<double>(x.size());
    }
    for (const double value : x) {
        largest = std::max(largest, std::abs(value - mean));
    }
    return largest;
}

/* How far the operator went; where that was not recorded, what it takes to hold the manipulator as far out. */
double usual_amplitude(const rig &rig, const record &shown)
{
    const double way_m = excursion_of(shown.command_position_m);
    if (!is_force_interface(rig)) {
        return std::max(way_m, excursion_of(shown.operator_position_m));
    }
    const double push_N = excursion_of(shown.operator_force_N);
    const double held_N = rig.firmware.manipulator.stiffness_N_per_m * way_m;
    return push_N > 0.0 ? push_N : std::max(held_N, excursion_of(shown.force_N));
}

/* As the rig that is told, but repeatable to the last bit. */
rig without_noise(rig rig)
{
    rig.run.lateness_file.clear();
    rig.run.emergency_stop_s = never;
    rig.run.enable_off_s = never;
    rig.robot.jitter_ms = 0.0;
    rig.robot.feedback_noise_m = 0.0;
    rig.sensor.noise_N = 0.0;
    rig.sensor.loss_probability = 0.0;
    rig.sensor.stale_probability = 0.0;
    rig.bus.loss_probability = 0.0;
    rig.bus.burst_probability = 0.0;
    rig.bus.error_probability = 0.0;
    rig.solver.kind = solver_kind::fast;
    for (const effect &known : effect_library()) {
        if (known.is_of_single_samples) {
            set_number(rig, known.parameters[0].key, 0.0);
        }
    }
    return rig;
}

rig with_excitation(rig rig, const excitation &excitation)
{
    const double offset_m = rig.profile.offset_m;
    rig.profile = excitation.profile;
    rig.profile.offset_m = offset_m;
    rig.run.duration_s = rig.run.release_s + excitation.duration_s;
    return rig;
}

} // namespace

std::string_view kind_of(const excitation &excitation)
{
    return find_key("profile.kind")->choices[static_cast<std::size_t>(excitation.profile.kind)];
}

std::string words_of(const excitation &excitation, const rig &rig)
{
    const profile_rig &told = excitation.profile;
    char text[160] = "";
    switch (told.kind) {
    case profile_kind::multisine:
    case profile_kind::chirp:
        std::snprintf(text, sizeof text, " from %.3g to %.3g Hz", told.frequency_start_Hz, told.frequency_end_Hz);
        break;
    case profile_kind::triangle:
        std::snprintf(text, sizeof text, " with a period of %.3g s", told.duration_s);
        break;
    case profile_kind::pulses:
        std::snprintf(text, sizeof text, " of %.3g s, one every %.3g s", 0.5 / told.frequency_end_Hz,
                      told.duration_s);
        break;
    default:
        break;
    }
    std::string words = std::string(kind_of(excitation)) + text;
    if (told.kind != profile_kind::rest) {
        const bool is_force = is_force_interface(rig);
        std::snprintf(text, sizeof text, ", amplitude %.3g %s", is_force ? told.amplitude_N : told.amplitude_m,
                      is_force ? "N" : "m");
        words += text;
    }
    std::snprintf(text, sizeof text, ", %.3g s", excitation.duration_s);
    return words + text;
}

std::vector<excitation> candidate_excitations(const rig &rig, const record &shown)
{
    const double recorded_s = shown.period_s * static_cast<double>(shown.size());
    const double duration_s = std::round(std::min(duration_max_s, std::max(duration_min_s, recorded_s)));
    const double usual = usual_amplitude(rig, shown);
    const double highest_Hz = std::min(10.0, 0.2 / shown.period_s);
    std::vector<excitation> all;
    const auto add = [&](profile_kind kind, double share, double period_s, double low_Hz, double high_Hz) {
        excitation made;
        made.profile.kind = kind;
        (is_force_interface(rig) ? made.profile.amplitude_N : made.profile.amplitude_m) = share * usual;
        made.profile.duration_s = period_s;
        made.profile.frequency_start_Hz = low_Hz;
        made.profile.frequency_end_Hz = high_Hz;
        made.duration_s = duration_s;
        all.push_back(made);
    };
    add(profile_kind::rest, 0.0, duration_s, 0.1, 1.0);
    for (const double share : {0.3, 1.0, 3.0}) {
        add(profile_kind::multisine, share, duration_s, 0.1, 0.2 * highest_Hz);
        add(profile_kind::triangle, share, 0.5 * duration_s, 0.1, 1.0);
        if (share < 1.0) {
            continue;
        }
        add(profile_kind::multisine, share, duration_s, 0.05, 0.05 * highest_Hz);
        add(profile_kind::multisine, share, duration_s, 0.1, highest_Hz);
        add(profile_kind::chirp, share, duration_s, 0.1, highest_Hz);
        add(profile_kind::step, share, duration_s, 0.1, 1.0);
        add(profile_kind::pulses, share, 0.125 * duration_s, 0.1, 0.5 * highest_Hz);
    }
    return all;
}

std::optional<record> simulate_experiment(const rig &hypothesis, const excitation &excitation,
                                          double excursion_max_m)
try {
    rig rig = with_excitation(without_noise(hypothesis), excitation);
    if (complete_and_check(rig)) {
        return {};
    }
    const auto app = std::make_unique<struct app>();
    const std::unique_ptr<struct hal, hal_status (*)(struct hal *)> hal(sim_open(rig), hal_close);
    app_start(app.get(), &rig.firmware);
    manipulator_stand_in manipulator(rig);
    record_of_ticks rows(rig);
    const double start_m = rig.firmware.manipulator.initial_position_m;
    while (app->supervisor.state != SUPERVISOR_STOPPED && loop_tick(hal.get(), app.get()) == HAL_OK) {
        const tick_record &tick = app->recorder.tick;
        const bool is_free = tick.limits == 0 && tick.rejected_frames == 0 && tick.stop_cause == 0;
        if (!is_free || !(std::abs(tick.command_position_m - start_m) < excursion_max_m)) {
            return {};
        }
        rows.add(tick);
        manipulator.replace(*app);
    }
    return rows.finish(rig, true);
} catch (const input_error &) {
    return {};
}

std::string profile_csv(const rig &rig, const excitation &excitation)
{
    const berth::rig made = with_excitation(rig, excitation);
    const profile profile(made);
    const bool is_force = is_force_interface(rig);
    const double offset = is_force ? 0.0 : rig.profile.offset_m; /* a run adds it */
    const double period_s = config_period_s(&rig.firmware);
    std::string text = is_force ? "t_s,operator_force_N\n" : "t_s,operator_position_m\n";
    char line[80];
    for (std::int64_t n = 0; period_s * static_cast<double>(n) <= excitation.duration_s; n++) {
        const double time_s = period_s * static_cast<double>(n);
        std::snprintf(line, sizeof line, "%.9g,%.10g\n", time_s, profile.at(time_s).value - offset);
        text += line;
    }
    return text;
}

} // namespace berth
