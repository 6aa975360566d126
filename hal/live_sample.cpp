#include "live_sample.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>

namespace berth
{

namespace
{

/* Of a name that a person chose: no character that JSON would want escaped. */
std::string plain(const std::string &name)
{
    constexpr std::size_t name_bytes_max = 64; /* a datagram stays below 1472 bytes, one frame of Ethernet */
    std::string text = name.substr(0, name_bytes_max);
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c < ' ' || c > '~' || c == '"' || c == '\\'; }, '?');
    return text;
}

/* ,"name":1.25; JSON knows no number that is not finite. */
void add_number(std::string &json, const char *name, double value)
{
    char text[64];
    std::snprintf(text, sizeof text, std::isfinite(value) ? ",\"%s\":%.9g" : ",\"%s\":null", name, value);
    json += text;
}

void add_count(std::string &json, const char *name, std::uint64_t value)
{
    char text[64];
    std::snprintf(text, sizeof text, ",\"%s\":%" PRIu64, name, value);
    json += text;
}

} // namespace

live_thinner::live_thinner(const live_source &source, double rate_Hz)
    : begin_(R"({"berth_live":1,"rig":")" + plain(source.rig) + R"(","config_hash":")" + plain(source.config_hash) +
             '"'),
      stride_ticks_(std::max<std::int64_t>(1, std::llround(1e9 / static_cast<double>(source.period_ns) / rate_Hz)))
{
    add_number(begin_, "period_ms", 1e-6 * static_cast<double>(source.period_ns));
    add_count(begin_, "run", source.run);
}

bool live_thinner::add(const tick_record &record)
{
    if (ticks_ == 0) {
        peak_force_N_ = record.force_N;
        limits_ = 0;
    }
    peak_force_N_ = std::abs(record.force_N) > std::abs(peak_force_N_) ? record.force_N : peak_force_N_;
    limits_ |= record.limits;
    missed_ticks_ += record.missed_ticks;
    last_ = record;
    ticks_ = (ticks_ + 1) % stride_ticks_;
    return ticks_ == 0;
}

std::string live_thinner::json(std::uint64_t unsent)
{
    std::string json = begin_;
    add_count(json, "sequence", sequence_++);
    add_count(json, "unsent", unsent);
    add_number(json, "time_s", 1e-9 * static_cast<double>(last_.scheduled_ns));
    add_number(json, "woke_late_ms", 1e-6 * static_cast<double>(last_.woke_ns - last_.scheduled_ns));
    add_number(json, "force_frame_age_ms", 1e-6 * static_cast<double>(last_.force_frame_age_ns));
    add_number(json, "operator_position_m", last_.operator_position_m);
    add_number(json, "operator_force_N", last_.operator_force_N);
    add_number(json, "manipulator_position_m", last_.manipulator_position_m);
    add_number(json, "command_position_m", last_.command_position_m);
    add_number(json, "robot_position_m", last_.robot_position_m);
    add_number(json, "force_N", last_.force_N);
    add_number(json, "peak_force_N", peak_force_N_);
    add_number(json, "energy_operator_J", last_.energy_operator_J);
    add_number(json, "energy_dissipated_J", last_.energy_dissipated_J);
    add_number(json, "energy_dead_time_J", last_.energy_dead_time_J);
    add_count(json, "missed_ticks", missed_ticks_);
    add_count(json, "rejected_frames", last_.rejected_frames);
    add_count(json, "lost_frames", last_.lost_frames);
    add_count(json, "state", last_.state);
    add_count(json, "stop_cause", last_.stop_cause);
    add_count(json, "limits", limits_);
    return json += '}';
}

} // namespace berth
