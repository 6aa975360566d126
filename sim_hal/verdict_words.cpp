#include "verdict_words.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "schedule.h"

namespace berth
{

const char *verdict_name(verdict_kind kind)
{
    static const char *const names[] = {"stable", "unstable", "limit cycle", "driven", "bouncing", "undetermined"};
    return names[static_cast<int>(kind)];
}

const char *growth_origin_name(growth_origin origin)
{
    static const char *const names[] = {"measured", "predicted", "run_without_noise"};
    return names[static_cast<int>(origin)];
}

double growth_finding::factor_time_s() const
{
    return std::log(2.0) / std::abs(growth_per_s);
}

std::string with_numbers(const char *format, double a, double b, double c)
{
    char text[200];
    std::snprintf(text, sizeof text, format, a, b, c);
    return text;
}

/* What stopped a run, in a sentence. */
std::string words_of(stop_cause cause)
{
    switch (cause) {
    case STOP_ENABLE_OFF:
        return "enable going off";
    case STOP_SENSOR_STALE:
        return "force samples that stayed away";
    case STOP_OPERATOR_STALE:
        return "operator commands that stayed away";
    case STOP_FEEDBACK_STALE:
        return "robot positions that stayed away";
    case STOP_SENSOR_SATURATED:
        return "the saturated sensor";
    case STOP_NOT_FINITE:
        return "a number that is not finite";
    case STOP_MISSED_TICKS:
        return "too many missed ticks";
    default:
        std::string name = stop_cause_name(cause);
        std::replace(name.begin(), name.end(), '_', ' ');
        return "the " + name;
    }
}

std::string stop_words(const run_stop &stop)
{
    return "stopped by " + words_of(stop.cause) + with_numbers(" after %.2f s", stop.after_s);
}

std::string predicted_words(const growth_prediction &prediction)
{
    const char *const who =
        prediction.source == prediction_source::lyapunov_exponent ? "the Lyapunov exponent is"
        : prediction.source == prediction_source::run             ? "a run without noise says"
        : prediction.source == prediction_source::contact         ? "the eigenvalues in contact say"
        : prediction.source == prediction_source::free_flight
            ? "the eigenvalues of the tool in free flight, where its inertia closes the loop, say"
            : "the eigenvalues say";
    std::string at = prediction.schedule.empty() ? "" : schedule_words(prediction) + ": ";
    if (prediction.amplitude_m > 0.0) {
        at += with_numbers("at a swing of %.3g mm ", 1e3 * prediction.amplitude_m);
    }
    const bool has_interval = prediction.source == prediction_source::lyapunov_exponent;
    const double growth_per_s = *prediction.growth_per_s;
    return at + who + " " +
           (has_interval ? (growth_per_s < 0.0 ? "" : "+") + rate_text(growth_per_s, prediction.ci95_per_s)
                         : with_numbers("%+.3g", growth_per_s)) +
           " /s";
}

std::string gaining_words(const growth_prediction &prediction)
{
    return with_numbers("each bounce returns %.5g of its speed: energy is gained", *prediction.restitution);
}

std::string relaxed_words(const bounce_finding &seen, const growth_prediction &prediction)
{
    return seen.gains() || !prediction.gains_by_bounces()
               ? ""
               : "; with the operator's spring relaxed at the surface " + gaining_words(prediction);
}

std::string tracking_words(const tracking_error &tracking)
{
    const double share = tracking.range_m > 0.0 ? 100.0 * tracking.rms_m / tracking.range_m : 0.0;
    return with_numbers("the robot is %.3g mm rms off the manipulator (%.2g %% of its range), %.3g mm at most",
                        1e3 * tracking.rms_m, share, 1e3 * tracking.peak_m);
}

std::string factor_words(const growth_finding &growth)
{
    return (growth.growth_per_s < 0.0 ? ": halves every " : ": doubles every ") +
           with_numbers("%.3g s", growth.factor_time_s());
}

std::string measured_words(const growth_finding &growth)
{
    return std::string("the oscillation ") + (growth.growth_per_s < 0.0 ? "decays by " : "grows by ") +
           rate_text(std::abs(growth.growth_per_s), growth.ci95_per_s) +
           with_numbers(" /s at %.4g Hz", growth.frequency_Hz) + factor_words(growth);
}

std::string motor_words(const motion_evidence &motion)
{
    return motion.motor_limit_share > 0.0
               ? with_numbers(
                     "; motors were at their torque limit in %.0f %% of its ticks: the growth of a saturated "
                     "loop says nothing of small motions",
                     std::ceil(100.0 * motion.motor_limit_share))
               : "";
}

std::string limited_words(const motion_evidence &motion)
{
    constexpr double most = 0.5; /* of the ticks: what the robot showed was the limits' motion */
    return motion.limited_share > most
               ? with_numbers("; limits acted in %.0f %% of the ticks, so that the robot did not show the simulated "
                              "motion: widen limits.*",
                              100.0 * motion.limited_share)
               : "";
}

std::string led_words(const motion_evidence &motion)
{
    if (!motion.led) {
        return "";
    }
    const force_at_limit &led = *motion.led;
    const std::string words =
        with_numbers("; the led force was at its limit of %.3g N in %.0f %% of the ticks from %.2f s on",
                     led.limit_N, std::ceil(100.0 * led.share), led.from_s);
    return words + (led.rattles() ? ", to the end: it rattles, so that the limit bounds what grows; lower "
                                    "object.mass_kg, raise manipulator.mass_kg, or lead the force otherwise"
                                  : " (sensor_channel.force_limit_N)");
}

std::string not_shown_words(const motion_evidence &motion)
{
    return motion.stop.is_of_motion() ? ""
           : motion.stop.is_early()   ? "; this run was stopped before it could show it"
           : !motion.has_moved        ? "; nothing moved in this run"
           : motion.is_too_short      ? "; this run is too short to show it"
           : motion.is_driven ? "; the operator drove most of this run, so berth does not judge it by its growth"
           : motion.growth.has_value() ? "; this run does not show whether it grows or decays"
                                       : "; this run has too little oscillation to measure it";
}

std::string with_prediction(std::string text, const growth_prediction &prediction)
{
    return prediction.growth_per_s ? std::move(text) + "; " + predicted_words(prediction) : text;
}

std::string left_out_words(const std::vector<std::string> &varies)
{
    std::string words;
    for (const std::string &one : varies) {
        words += (words.empty() ? "" : ", ") + one;
    }
    return words.empty() ? "" : "; the limits are those without what changes it from tick to tick (" + words + ")";
}

std::string beyond_words(const growth_prediction &prediction)
{
    return "; " + predicted_words(prediction) +
           " for small motions: noise, limits, events of the run and the size of the motion are not in it";
}

std::string rate_text(double value, double ci95)
{
    if (!(ci95 > 0.0)) {
        return with_numbers("%.3g", value);
    }
    const int more = std::abs(value) < 2.0 * ci95 ? 1 : 0; /* so that one digit does not make them alike */
    const int decimals = std::clamp(more - static_cast<int>(std::floor(std::log10(ci95))), 0, 12);
    char text[80];
    std::snprintf(text, sizeof text, "%.*f +- %.*f", decimals, value, decimals, ci95);
    return text;
}

std::string caveat_words(const motion_evidence &motion, const growth_prediction &prediction)
{
    constexpr double far_off = 3.0; /* intervals */
    constexpr double alike = 2.0;   /* a factor */
    if (!motion.growth || motion.is_driven || !is_stable_in_contact(prediction)) {
        return "";
    }
    const double seen_per_s = motion.growth->growth_per_s;
    const double said_per_s = *prediction.growth_per_s;
    const double ci95_per_s = std::hypot(motion.growth->growth_ci95_per_s, prediction.ci95_per_s);
    const double ratio = seen_per_s / said_per_s;
    if (std::abs(seen_per_s - said_per_s) <= far_off * ci95_per_s || (ratio < alike && ratio > 1.0 / alike)) {
        return "";
    }
    const std::string both = with_numbers("predicted %+.3g /s, this run measured %+.3g +- %.1g /s: ", said_per_s,
                                          seen_per_s, motion.growth->growth_ci95_per_s);
    if (motion.motor_limit_share > 0.0) {
        return both + "motors were at their torque limit; for small motions believe the prediction";
    }
    return both +
           (seen_per_s < said_per_s
                ? "another mode was excited, or the run is too short for the one that decides; believe the "
                  "prediction"
                : "noise, limits, events or the size of the motion do what the prediction leaves out; believe "
                  "the run");
}

std::string margin_words(const stability_margin &margin)
{
    if (margin.is_unlimited) {
        return margin.note;
    }
    std::string text;
    if (margin.dead_time_ms) {
        text = with_numbers(margin.is_dead_time_open
                                ? "the dead time may grow by at least %.4g ms before the loop is unstable"
                                : "the dead time may grow by %.4g ms before the loop is unstable",
                            *margin.dead_time_ms);
    }
    if (!margin.stable_again_ms.empty()) {
        const auto [from, to] = margin.stable_again_ms.front();
        const bool is_open = margin.is_again_open && margin.stable_again_ms.size() == 1;
        text += with_numbers(is_open ? "; stable again from %.4g to at least %.4g ms of dead time"
                                     : "; stable again from %.4g to %.4g ms of dead time",
                             from, to);
        text +=
            margin.stable_again_ms.size() > 1
                ? with_numbers(", and in %.0f more beyond", static_cast<double>(margin.stable_again_ms.size()) - 1.0)
                : "";
    }
    if (margin.modulus) {
        text += (text.empty() ? "" : "; ") + with_numbers("modulus %.4f (0: unstable)", *margin.modulus);
    }
    if (!margin.note.empty()) {
        text += (text.empty() ? "not known: " : "; ") + margin.note;
    }
    return text;
}

} // namespace berth
