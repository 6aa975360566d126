#include "record.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numeric>

#include "../../firmware/compensation/compensation.h"
#include "../../firmware/supervisor.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"
#include "../log/ulog_reader.h"
#include "record_table.h"

namespace berth
{

namespace
{

struct signal_member {
    std::string_view name;
    std::vector<double> record::*member;
};

constexpr signal_member signal_members[] = {
    {"t_s", &record::time_s},
    {"operator_force_N", &record::operator_force_N},
    {"operator_position_m", &record::operator_position_m},
    {"operator_velocity_m_per_s", &record::operator_velocity_m_per_s},
    {"command_position_m", &record::command_position_m},
    {"robot_position_m", &record::robot_position_m},
    {"force_N", &record::force_N},
};

std::string text(const char *format, double a, double b = 0.0)
{
    char result[200];
    std::snprintf(result, sizeof result, format, a, b);
    return result;
}

signal_source source_of(const rig &rig, std::string_view signal)
{
    for (const signal_source &source : rig.signals) {
        if (source.signal == signal) {
            return source;
        }
    }
    return {std::string(signal), std::string(signal), 1.0, 0.0};
}

/* A column with the right name but another unit is a mistake that would pass unseen. */
void refuse_other_unit(const record_table &table, const std::string &path, std::string_view signal)
{
    const std::string_view bare = signal.substr(0, signal.rfind('_'));
    for (const table_column &column : table.columns) {
        const bool is_like = column.name.size() > bare.size() && column.name.substr(0, bare.size()) == bare &&
                             column.name[bare.size()] == '_' && column.name != signal;
        const bool is_other = std::any_of(std::begin(signal_members), std::end(signal_members),
                                          [&](const signal_member &known) { return known.name == column.name; });
        if (is_like && !is_other) {
            throw input_error(path + ":1: " + column.name + " has another unit than " + std::string(signal) +
                              "; say in the rig file [signals] " + std::string(signal) + " = { column = \"" +
                              column.name + "\", scale = ... }");
        }
    }
}

void check_values(const record &made)
{
    for (const signal_member &signal : signal_members) {
        const std::vector<double> &values = made.*signal.member;
        if (values.empty() || signal.name == "t_s") {
            continue;
        }
        const auto [least, largest] = std::minmax_element(values.begin(), values.end());
        const bool is_output = signal.name != "operator_force_N" && signal.name.substr(0, 8) != "operator";
        if (*least == *largest && is_output) {
            throw input_error(made.path + ": " + std::string(signal.name) + " is " + text("%g", *least) +
                              " in every row; a column that never changes says nothing about the rig");
        }
    }
}

constexpr double gap = 1.5; /* in periods: a row is missing */

/* Time runs on evenly, with jitter that is not a row; anything else starts a new segment. */
void find_segments(record &made, const std::vector<double> &labels, double period_s)
{
    double largest_jitter = 0.0;
    std::size_t gaps = 0;
    record_segment part{0, 0};
    for (std::size_t n = 1; n <= made.size(); n++) {
        const bool is_end = n == made.size();
        const bool is_new_label = !is_end && !labels.empty() && labels[n] != labels[n - 1];
        const double step_s = is_end ? 0.0 : made.time_s[n] - made.time_s[n - 1];
        if (!is_end && !is_new_label && step_s <= 0.0) {
            throw input_error(made.path + ":" + std::to_string(n + 2) + ": t_s goes from " +
                              text("%.9g to %.9g", made.time_s[n - 1], made.time_s[n]) +
                              "; time must increase, or a column `segment` must tell the parts apart");
        }
        const bool is_gap = !is_end && !is_new_label && step_s > gap * period_s;
        if (is_end || is_new_label || is_gap) {
            part.end = n;
            made.segments.push_back(part);
            part.begin = n;
            gaps += is_gap;
        } else {
            largest_jitter = std::max(largest_jitter, std::abs(step_s - period_s));
        }
    }
    if (gaps > 0) {
        made.notes.push_back(std::to_string(gaps) + " gaps in time: the parts between them are replayed one by one");
    }
    if (largest_jitter > 0.01 * period_s) {
        made.notes.push_back(
            text("time stamps jitter by up to %.3g ms; rows count as evenly spaced", 1e3 * largest_jitter));
    }
}

/* Mean of the steps between rows that are no gap: what rounding and jitter do to the stamps averages out. */
double row_spacing_s(const record &made)
{
    constexpr std::size_t rows_min = 50;
    if (made.size() < rows_min) {
        throw input_error(made.path + ": has " + std::to_string(made.size()) + " rows; a diagnosis needs at least " +
                          std::to_string(rows_min) + ", and a minute is better");
    }
    std::vector<double> steps;
    for (std::size_t n = 1; n < made.size(); n++) {
        if (made.time_s[n] > made.time_s[n - 1]) {
            steps.push_back(made.time_s[n] - made.time_s[n - 1]);
        }
    }
    if (steps.empty()) {
        throw input_error(made.path + ": t_s never increases");
    }
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    const double longest_s = gap * steps[steps.size() / 2];
    const auto evenly =
        std::partition(steps.begin(), steps.end(), [&](double step_s) { return step_s <= longest_s; });
    return std::accumulate(steps.begin(), evenly, 0.0) / static_cast<double>(evenly - steps.begin());
}

/* To the whole ns that a loop's period has. */
double loop_rate_Hz(double period_s)
{
    return 1e9 / std::max(1.0, std::round(1e9 * period_s));
}

/* How far off a rate may be: a lightly damped resonance moves by less than its width. */
constexpr double rate_tolerance = 1e-3;

void finish(record &made, const std::vector<double> &labels, const rig &rig, bool may_be_still)
{
    const double spacing_s = row_spacing_s(made);
    made.period_s = rig.is_rate_given ? config_period_s(&rig.firmware) : 1.0 / loop_rate_Hz(spacing_s);
    if (std::abs(spacing_s - made.period_s) > rate_tolerance * made.period_s) {
        throw input_error(
            made.path + ": " +
            text("its rows are %.7g ms apart, those of the rig %.7g ms", 1e3 * spacing_s, 1e3 * made.period_s) +
            "; say " + text("--set loop.rate_Hz=%.15g", loop_rate_Hz(spacing_s)));
    }
    if (!may_be_still) {
        check_values(made);
    }
    find_segments(made, labels, made.period_s);
}

bool is_log(const std::string &path)
{
    return path.size() > 4 && path.substr(path.size() - 4) == ".ulg";
}

record read_csv(const std::string &path, const rig &rig, bool may_be_still)
{
    record made;
    made.path = path;
    std::vector<std::string> wanted{source_of(rig, "segment").column};
    for (const signal_member &signal : signal_members) {
        wanted.push_back(source_of(rig, signal.name).column);
    }
    const record_table table = read_record_table(path, wanted);
    made.hash = table.hash;
    for (const signal_member &signal : signal_members) {
        const signal_source source = source_of(rig, signal.name);
        const table_column *const column = table.find(source.column);
        const bool is_mapped = source.column != signal.name;
        if (column == nullptr) {
            if (is_mapped || signal.name == "t_s") {
                throw input_error(path + ":1: there is no column " + source.column + " for " +
                                  std::string(signal.name) + "; the columns are " + table.names());
            }
            refuse_other_unit(table, path, signal.name);
            continue;
        }
        std::vector<double> &values = made.*signal.member;
        values = column->values;
        for (double &value : values) {
            value = source.scale * value + source.offset;
        }
    }
    if (!made.operator_position_m.empty() && made.operator_velocity_m_per_s.empty()) {
        made.notes.push_back("operator_velocity_m_per_s is missing and counts as 0");
    }
    made.time_origin_s = made.time_s.empty() ? 0.0 : made.time_s.front();
    const table_column *const labels = table.find(source_of(rig, "segment").column);
    finish(made, labels == nullptr ? std::vector<double>{} : labels->values, rig, may_be_still);
    return made;
}

/* A log is read as a whole. */
void refuse_large_log(const std::string &path)
{
    constexpr std::uintmax_t bytes_a_tick_max = 500; /* a tick, its frames and the rig's truth: 360 */
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(path, error);
    if (!error && bytes > bytes_a_tick_max * record_rows_max) {
        check_row_count(path, record_rows_max + 1);
    }
}

record read_log(const std::string &path, const rig &rig, bool may_be_still)
{
    refuse_large_log(path);
    ulog_reader log(path);
    const berth::rig recorded = log.recorded_rig();
    record_of_ticks rows(recorded);
    rows.made.path = path;
    rows.made.hash = text_hash(read_file(path));
    std::uint16_t id = 0;
    std::string_view bytes;
    while (log.next(id, bytes)) {
        if (id == ULOG_TICK_ID && bytes.size() == sizeof(tick_record)) {
            rows.add(record_as<tick_record>(bytes));
        }
    }
    if (log.is_cut() || log.has_dropouts()) {
        rows.made.notes.push_back("the log is not complete");
    }
    return rows.finish(rig, may_be_still);
}

} // namespace

record_of_ticks::record_of_ticks(const rig &rig)
    : is_force_(rig.firmware.operator_command.interface == OPERATOR_INTERFACE_FORCE), is_late_(!rig.bus.ideal),
      is_compensated_(compensation_is_on(&rig.firmware) != 0)
{
    made.is_from_this_firmware = !has_body_effects(rig, "manipulator"); /* else a stand-in moved it */
    if (is_compensated_) {
        made.notes.emplace_back("recorded with compensation: the manipulator felt another force than the measured "
                                "one, and was displayed elsewhere; its block is left out");
    }
}

void record_of_ticks::add(const tick_record &tick)
{
    const bool is_running = tick.state == SUPERVISOR_RUNNING;
    label_ += is_running && !was_running_;
    was_running_ = is_running;
    if (!is_running) {
        return;
    }
    check_row_count(made.path, made.size() + 1);
    labels_.push_back(label_);
    made.time_s.push_back(1e-9 * static_cast<double>(tick.scheduled_ns));
    if (is_compensated_) {
        /* no operator: nothing to replay the manipulator from */
    } else if (is_force_) {
        made.operator_force_N.push_back(tick.operator_force_N);
    } else {
        made.operator_position_m.push_back(tick.operator_position_m);
        made.operator_velocity_m_per_s.push_back(tick.operator_velocity_m_per_s);
    }
    made.command_position_m.push_back(tick.command_position_m);
    made.robot_position_m.push_back(tick.robot_position_m);
    made.force_N.push_back(tick.force_N);
}

record record_of_ticks::finish(const rig &wanted, bool may_be_still)
{
    /* A report takes its time on the bus: at a tick the loop knows where the robot was one tick before. */
    if (is_late_ && made.size() > 1) {
        for (std::size_t n = 0; n + 1 < made.size(); n++) {
            made.robot_position_m[n] = made.robot_position_m[n + 1];
        }
        for (auto member : {&record::time_s, &record::operator_force_N, &record::operator_position_m,
                            &record::operator_velocity_m_per_s, &record::command_position_m,
                            &record::robot_position_m, &record::force_N}) {
            if (!(made.*member).empty()) {
                (made.*member).pop_back();
            }
        }
        labels_.pop_back();
    }
    berth::finish(made, labels_, wanted, may_be_still);
    return std::move(made);
}

record read_record(const std::string &path, const rig &rig, bool may_be_still)
{
    return is_log(path) ? read_log(path, rig, may_be_still) : read_csv(path, rig, may_be_still);
}

} // namespace berth
