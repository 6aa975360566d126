#include "profile.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../../firmware/pi.h"
#include "../../hal/rig/rig_file.h"
#include "random.h"

namespace berth
{

namespace
{

constexpr int tone_count = 16;

/* 10 s^3 - 15 s^4 + 6 s^5: from rest to rest with continuous acceleration. */
profile_point minimum_jerk(double s, double duration_s)
{
    return {s * s * s * (10.0 + s * (-15.0 + 6.0 * s)), 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration_s};
}

/* Frequency rises linearly over the duration, then the profile rests. */
profile_point chirp(const profile_rig &rig, double time_s)
{
    if (time_s >= rig.duration_s) {
        return {0.0, 0.0};
    }
    const double slope = (rig.frequency_end_Hz - rig.frequency_start_Hz) / rig.duration_s;
    const double phase = two_pi * time_s * (rig.frequency_start_Hz + 0.5 * slope * time_s);
    return {std::sin(phase), std::cos(phase) * two_pi * (rig.frequency_start_Hz + slope * time_s)};
}

/* Up, down past 0, and back, at one speed. */
profile_point triangle(const profile_rig &rig, double time_s)
{
    const double share = std::fmod(time_s / rig.duration_s, 1.0);
    const double slope = 4.0 / rig.duration_s;
    if (share < 0.25) {
        return {4.0 * share, slope};
    }
    return share < 0.75 ? profile_point{2.0 - 4.0 * share, -slope} : profile_point{4.0 * share - 4.0, slope};
}

/* A half sine at the start of each period, rest after it. */
profile_point pulses(const profile_rig &rig, double time_s)
{
    const double w = two_pi * rig.frequency_end_Hz;
    const double phase = w * std::fmod(time_s, rig.duration_s);
    return phase < 0.5 * two_pi ? profile_point{std::sin(phase), w * std::cos(phase)} : profile_point{0.0, 0.0};
}

/* The loop would reject such commands one by one, and stop for want of any. */
void refuse_beyond_limits(const rig &rig, const csv_columns &read, double offset)
{
    const operator_config &limits = rig.firmware.operator_command;
    const bool is_motion = limits.interface == OPERATOR_INTERFACE_MOTION;
    const double most = is_motion ? limits.position_limit_m : limits.force_limit_N;
    const auto refuse = [&](std::size_t row, const char *what, double value, const char *unit, const char *key,
                            double limit) {
        char text[240];
        std::snprintf(text, sizeof text,
                      "%s of %g %s is beyond %s = %g: the loop would reject it; make it smaller, "
                      "perhaps by profile.scale (is %g)",
                      what, value, unit, key, limit, rig.profile.scale);
        throw input_error(rig.profile.file + ":" + std::to_string(read.lines[row]) + ": " + text);
    };
    for (std::size_t i = 0; i < read.values.size(); i++) {
        const double value = offset + rig.profile.scale * read.values[i];
        if (std::abs(value) > most) {
            refuse(i, is_motion ? "a position" : "a force", value, is_motion ? "m" : "N",
                   is_motion ? "operator.position_limit_m" : "operator.force_limit_N", most);
        }
        const double rate = i == 0 ? 0.0
                                   : rig.profile.scale * (read.values[i] - read.values[i - 1]) /
                                         (read.times_s[i] - read.times_s[i - 1]);
        if (is_motion && std::abs(rate) > limits.velocity_limit_m_per_s) {
            refuse(i, "the way from the row before to this one, at a velocity", rate, "m/s",
                   "operator.velocity_limit_m_per_s", limits.velocity_limit_m_per_s);
        }
    }
}

} // namespace

profile::profile(const rig &rig)
    : rig_(rig.profile),
      offset_(rig.firmware.operator_command.interface == OPERATOR_INTERFACE_MOTION ? rig.profile.offset_m : 0.0),
      amplitude_(rig.firmware.operator_command.interface == OPERATOR_INTERFACE_FORCE ? rig.profile.amplitude_N
                                                                                     : rig.profile.amplitude_m)
{
    if (rig_.kind == profile_kind::file) {
        const bool is_motion = rig.firmware.operator_command.interface == OPERATOR_INTERFACE_MOTION;
        csv_columns read = read_csv_columns(
            rig_.file, {rig_.column, is_motion ? "m" : "N", rig_.scale, "profile.column", "profile.scale"});
        refuse_beyond_limits(rig, read, offset_);
        note_ = std::move(read.note);
        times_s_ = std::move(read.times_s);
        values_ = std::move(read.values);
    }
    if (rig_.kind == profile_kind::multisine) {
        /* Whole periods in the duration, evenly spaced in frequency, random phases: repeats without a step. */
        random_stream random(rig.run.seed, stream_profile);
        for (int i = 0; i < tone_count; i++) {
            const double wanted_Hz =
                rig_.frequency_start_Hz + (rig_.frequency_end_Hz - rig_.frequency_start_Hz) * i / (tone_count - 1.0);
            const double periods = std::max(1.0, std::round(wanted_Hz * rig_.duration_s));
            tones_.push_back({periods / rig_.duration_s, two_pi * random.uniform()});
        }
    }
}

profile_point profile::multisine(double time_s) const
{
    const double share = 1.0 / std::sqrt(static_cast<double>(tones_.size()));
    profile_point point{0.0, 0.0};
    for (const tone &part : tones_) {
        const double w = two_pi * part.frequency_Hz;
        point.value += share * (std::sin(w * time_s + part.phase_rad) - std::sin(part.phase_rad));
        point.rate += share * w * std::cos(w * time_s + part.phase_rad);
    }
    return point;
}

/* Straight lines between samples; before the first and after the last the value is held. */
profile_point profile::from_file(double time_s) const
{
    const double t = times_s_.front() + time_s;
    const auto after = std::upper_bound(times_s_.begin(), times_s_.end(), t);
    if (after == times_s_.end()) {
        return {values_.back(), 0.0};
    }
    const std::size_t i = static_cast<std::size_t>(after - times_s_.begin());
    const double slope = (values_[i] - values_[i - 1]) / (times_s_[i] - times_s_[i - 1]);
    return {values_[i - 1] + slope * (t - times_s_[i - 1]), slope};
}

profile_point profile::at(double time_s) const
{
    const double t = time_s - rig_.start_s;
    const bool is_file = rig_.kind == profile_kind::file;
    const double scale = is_file ? rig_.scale : amplitude_;
    if (t < 0.0) {
        return {offset_ + (is_file ? scale * values_.front() : 0.0), 0.0};
    }
    profile_point point{0.0, 0.0};
    switch (rig_.kind) {
    case profile_kind::rest:
        break;
    case profile_kind::step:
        point = {1.0, 0.0};
        break;
    case profile_kind::ramp:
        point = t < rig_.duration_s ? profile_point{t / rig_.duration_s, 1.0 / rig_.duration_s}
                                    : profile_point{1.0, 0.0};
        break;
    case profile_kind::minimum_jerk:
        point = minimum_jerk(std::min(1.0, t / rig_.duration_s), rig_.duration_s);
        break;
    case profile_kind::chirp:
        point = chirp(rig_, t);
        break;
    case profile_kind::multisine:
        point = multisine(t);
        break;
    case profile_kind::triangle:
        point = triangle(rig_, t);
        break;
    case profile_kind::pulses:
        point = pulses(rig_, t);
        break;
    case profile_kind::file:
        point = from_file(t);
        break;
    }
    return {offset_ + scale * point.value, scale * point.rate};
}

} // namespace berth
