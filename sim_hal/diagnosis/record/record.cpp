#include "record.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <numeric>

#include "../../../firmware/compensation/compensation.h"
#include "../../../firmware/supervisor.h"
#include "../../../hal/rig/rig_file.h"
#include "../../effects/active.h"
#include "../../log/ulog_reader.h"
#include "../formatted.h"
#include "../replay/robot_start.h"
#include "record_columns.h"
#include "record_rows.h"
#include "record_table.h"
#include "tick_table.h"

namespace berth
{

namespace
{

/* Central differences over two periods, one-sided at the ends of a part. */
void differentiate_operator(record &made)
{
    const std::vector<double> &x = made.operator_position_m;
    if (x.empty() || !made.operator_velocity_m_per_s.empty()) {
        return;
    }
    std::vector<double> v(x.size(), 0.0);
    for (const record_segment &part : made.segments) {
        for (std::size_t n = part.begin; n < part.end; n++) {
            const std::size_t before = n > part.begin ? n - 1 : n;
            const std::size_t after = n + 1 < part.end ? n + 1 : n;
            const double apart_s = static_cast<double>(after - before) * made.period_s;
            v[n] = after > before ? (x[after] - x[before]) / apart_s : 0.0;
        }
    }
    made.operator_velocity_m_per_s = std::move(v);
    made.is_velocity_derived = true;
    made.notes.push_back("operator_velocity_m_per_s is missing: taken as differences of operator_position_m");
}

/* To the whole ns that a loop's period has. */
double loop_rate_Hz(double period_s)
{
    return 1e9 / std::max(1.0, std::round(1e9 * period_s));
}

/* How far off a rate may be: a lightly damped resonance moves by less than its width. */
constexpr double rate_tolerance = 1e-3;

/* Seconds that are ms fit a thousand times better than any rate. */
std::string remedy_of(double spacing_s, double period_s, const std::string &column)
{
    constexpr double nearly = 0.01;
    if (std::abs(1e-3 * spacing_s - period_s) < nearly * period_s) {
        return "[signals] t_s = { column = \"" + column + "\", scale = 0.001 } in the rig file if " + column +
               " is in ms";
    }
    return formatted("--set loop.rate_Hz=%.15g", loop_rate_Hz(spacing_s));
}

/* What tells whether two records are the same measurement: their signals, whatever the file around them. */
std::uint64_t content_of(const record &made)
{
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const signal_member &signal : signal_members) {
        const std::vector<double> &values = made.*signal.member;
        hash = (hash ^ values.size()) * 0x100000001b3u;
        for (std::size_t n = 0; signal.name != "t_s" && n < values.size(); n++) {
            std::uint64_t bits = 0;
            std::memcpy(&bits, &values[n], sizeof bits);
            hash = (hash ^ bits) * 0x100000001b3u;
            hash ^= hash >> 32; /* FNV-1a is made for bytes: of words it would lose the high bits */
        }
    }
    return hash;
}

void finish(record &made, const row_marks &marks, const rig &rig)
{
    check_labels(made, marks, source_of(rig, "segment").column);
    const row_spacing spacing = spacing_of(made, marks);
    const double given_s = config_period_s(&rig.firmware);
    /* A logger whose delays add up has the period of its usual steps: rounded stamps of another one look the same.
     */
    const bool is_usual_step = rig.is_rate_given && spacing.clock.has_usual_step &&
                               std::abs(spacing.clock.median_step_s - given_s) <= rate_tolerance * given_s;
    const double spacing_s = is_usual_step ? given_s : spacing.clock.line_s;
    made.period_s = rig.is_rate_given ? given_s : 1.0 / loop_rate_Hz(spacing_s);
    if (std::abs(spacing_s - made.period_s) > rate_tolerance * made.period_s) {
        throw input_error(
            made.path + ": " +
            formatted("its rows are %.7g ms apart, those of the rig %.7g ms", 1e3 * spacing_s, 1e3 * made.period_s) +
            "; say " + remedy_of(spacing_s, made.period_s, source_of(rig, "t_s").column));
    }
    made.content = content_of(made);
    find_segments(made, spacing.parts);
    differentiate_operator(made);
}

bool is_log(const std::string &path)
{
    return path.size() > 4 && path.substr(path.size() - 4) == ".ulg";
}

record read_csv(const std::string &path, const rig &rig, bool may_be_still)
{
    record made;
    made.path = path;
    const std::string segment = source_of(rig, "segment").column;
    std::vector<std::string> wanted{segment};
    for (const signal_member &signal : signal_members) {
        wanted.push_back(source_of(rig, signal.name).column);
    }
    wanted.insert(wanted.end(), tick_columns.begin(), tick_columns.end());
    const record_table table = read_record_table(path, source_of(rig, "t_s").column, wanted);
    if (is_table_of_ticks(table, rig)) {
        return record_of_table(table, path, rig, may_be_still);
    }
    made.hash = table.hash;
    made.header_line = table.header_line;
    take_columns(made, table, rig);
    made.time_origin_s = made.time_s.empty() ? 0.0 : made.time_s.front();
    const table_column *const labels = table.find(segment);
    finish(made, {labels == nullptr ? std::vector<double>{} : labels->values, table.lines}, rig);
    if (!may_be_still) {
        const std::string place = path + ":" + std::to_string(table.header_line) + ": ";
        check_outputs(made, place);
        check_operator(made, place);
    }
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
    rows.made.hash = text_hash(log.bytes());
    std::uint16_t id = 0;
    std::string_view bytes;
    while (log.next(id, bytes)) {
        if (id == ULOG_TICK_ID && bytes.size() == sizeof(tick_record)) {
            rows.add(record_as<tick_record>(bytes));
        }
    }
    if (log.condition().is_cut || log.has_dropouts()) {
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
    is_limited_ = is_limited_ || tick.limits != 0;
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
    if (is_limited_ && !is_compensated_) {
        made.operator_force_N.clear();
        made.operator_position_m.clear();
        made.operator_velocity_m_per_s.clear();
        made.notes.emplace_back(
            "recorded while limits of the firmware acted: the command is not where the manipulator "
            "was; its block is left out");
    }
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
    berth::finish(made, {labels_, {}}, wanted);
    if (!may_be_still) {
        check_outputs(made, made.path + ": ");
    }
    return std::move(made);
}

record first_rows(const record &whole, std::size_t rows)
{
    record made = whole;
    const auto cut = [](auto &values, std::size_t count) { values.resize(std::min(values.size(), count)); };
    for (const auto signal : record_signals) {
        cut(made.*signal, rows);
    }
    cut(made.time_s, rows);
    cut(made.push_within_rows_N, rows * pushes_a_row);
    cut(made.bend_m_per_s2, rows);
    cut(made.filled, rows);
    const auto is_later = [&](const record_segment &part) { return part.begin >= rows; };
    made.segments.erase(std::remove_if(made.segments.begin(), made.segments.end(), is_later), made.segments.end());
    for (record_segment &part : made.segments) {
        part.end = std::min(part.end, rows);
    }
    return made;
}

record read_record(const std::string &path, const rig &rig, bool may_be_still)
{
    return is_log(path) ? read_log(path, rig, may_be_still) : read_csv(path, rig, may_be_still);
}

} // namespace berth
