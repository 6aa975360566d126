#include "record_rows.h"

#include <algorithm>
#include <cmath>

#include "../../../hal/rig/rig_file.h"
#include "../formatted.h"
#include "../replay/robot_start.h"
#include "record_columns.h"
#include "record_gaps.h"
#include "row_times.h"

namespace berth
{

namespace
{

constexpr double jitter_least = 0.01; /* of a period: less is not worth a word */
constexpr double longest_step = 1.5;  /* in median steps: what is longer is no step to the next row */

std::string place_of(const record &made, const row_marks &marks, std::size_t row)
{
    return marks.lines.empty() ? made.path + ": row " + std::to_string(row + 1)
                               : made.path + ":" + std::to_string(marks.lines[row]);
}

void refuse_few_rows(const record &made)
{
    constexpr std::size_t rows_min = 50;
    if (made.size() < rows_min) {
        throw input_error(made.path + ": has " + std::to_string(made.size()) + " rows; a diagnosis needs at least " +
                          std::to_string(rows_min) + ", and a minute is better");
    }
}

/* The positive ones. Stamps that are rounded repeat; a row that came twice is another matter. */
std::vector<double> steps_of(const record &made)
{
    constexpr std::size_t rounded = 10; /* one in so many rows repeats a stamp: no row that came twice */
    std::vector<double> steps;
    std::size_t repeats = 0;
    for (std::size_t n = 1; n < made.size(); n++) {
        if (made.time_s[n] > made.time_s[n - 1]) {
            steps.push_back(made.time_s[n] - made.time_s[n - 1]);
        }
        repeats += made.time_s[n] == made.time_s[n - 1];
    }
    if (!steps.empty() && rounded * repeats > made.size()) {
        throw input_error(made.path + ": t_s repeats in " + std::to_string(repeats) + " of " +
                          std::to_string(made.size()) +
                          " rows: its stamps are rounded; write it with more digits, or each row's number over the "
                          "rate in its place");
    }
    if (steps.empty()) {
        throw input_error(made.path +
                          ": t_s never increases; is it another column, or are the rows the last one first?");
    }
    return steps;
}

double quantile(std::vector<double> &values, double share)
{
    const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
    std::nth_element(values.begin(), place, values.end());
    return *place;
}

std::string no_constant_rate(const record &made, const std::string &why)
{
    return made.path + ": its rows have no constant rate: " + why +
           "; log at a constant rate, or bring it to one before";
}

double median_step_s(const record &made)
{
    constexpr double uneven = 0.4; /* between the quarters of the steps: no clock jitters so */
    std::vector<double> steps = steps_of(made);
    const double longest_s = longest_step * quantile(steps, 0.5);
    steps.erase(std::remove_if(steps.begin(), steps.end(), [&](double step_s) { return step_s > longest_s; }),
                steps.end());
    const double quarter_s = quantile(steps, 0.25);
    const double three_quarters_s = quantile(steps, 0.75);
    if (three_quarters_s - quarter_s > uneven * three_quarters_s) {
        throw input_error(no_constant_rate(made, formatted("half of the steps of t_s are outside of %.4g to %.4g ms",
                                                           1e3 * quarter_s, 1e3 * three_quarters_s)));
    }
    return quantile(steps, 0.5);
}

std::vector<stamped_part> parts_of(const record &made, const row_marks &marks)
{
    std::vector<stamped_part> parts{{0, made.size()}};
    for (std::size_t n = 1; n < made.size(); n++) {
        if (!marks.labels.empty() && marks.labels[n] != marks.labels[n - 1]) {
            parts.back().end = n;
            parts.push_back({n, made.size()});
        } else if (made.time_s[n] <= made.time_s[n - 1]) {
            throw input_error(place_of(made, marks, n) + ": t_s goes from " +
                              formatted("%.9g to %.9g", made.time_s[n - 1], made.time_s[n]) +
                              "; time must increase, or a column `segment` must tell the parts apart");
        }
    }
    return parts;
}

/* Stamps come late and rows are missing, but the loop's period does not change. */
void refuse_drifting_rate(const record &made, const row_spacing &spacing)
{
    constexpr std::size_t stretch = 200; /* rows */
    constexpr std::size_t apart = 16;    /* rows, over which the rounding of stamps averages out */
    constexpr double off = 0.01;
    if (spacing.clock.has_usual_step) {
        return;
    }
    const double period_s = spacing.clock.line_s;
    for (const stamped_part &part : spacing.parts) {
        for (std::size_t begin = part.begin; begin + stretch <= part.end; begin += stretch) {
            std::vector<double> steps_s;
            for (std::size_t n = begin; n + apart < begin + stretch; n++) {
                steps_s.push_back((made.time_s[n + apart] - made.time_s[n]) / apart);
            }
            const double here_s = quantile(steps_s, 0.5);
            if (std::abs(here_s - period_s) > off * period_s) {
                throw input_error(
                    no_constant_rate(made, formatted("steps of t_s are %.4g ms long in places, and %.4g ms over all",
                                                     1e3 * here_s, 1e3 * period_s)));
            }
        }
    }
}

/* How many of what, for the notes. */
struct row_findings {
    std::vector<missing_rows> missing;
    std::size_t gaps = 0;
    std::size_t late = 0;
    double latest_s = 0.0;
    double jitter_s = 0.0;
    std::size_t at_stamps = 0; /* rows that were brought to an even grid */
};

std::string counted(std::size_t count, const std::string &one)
{
    return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
}

void add_notes(record &made, const row_findings &found)
{
    if (found.gaps > 0) {
        made.notes.push_back(counted(found.gaps, "gap") + " in time: each part is replayed by itself");
    }
    if (!found.missing.empty()) {
        made.notes.push_back("rows are missing in " + counted(found.missing.size(), "place") +
                             ", a few in each: the commands in between are interpolated, and nothing is "
                             "compared there");
    }
    if (found.at_stamps > 0) {
        made.notes.push_back(
            formatted("time stamps jitter by up to %.3g ms, and the position is smooth over them: rows "
                      "were taken at their stamps, and are brought to even times",
                      1e3 * std::max(found.jitter_s, found.latest_s)));
        return;
    }
    if (found.late > 0) {
        made.notes.push_back(
            counted(found.late, "time stamp") +
            formatted(" late, by up to %.3g ms: these rows count where they were due", 1e3 * found.latest_s));
    }
    if (found.jitter_s > jitter_least * made.period_s) {
        made.notes.push_back(
            formatted("time stamps jitter by up to %.3g ms; rows count as evenly spaced", 1e3 * found.jitter_s));
    }
}

std::vector<double> part_of(const std::vector<double> &values, stamped_part rows)
{
    return {values.begin() + static_cast<std::ptrdiff_t>(rows.begin),
            values.begin() + static_cast<std::ptrdiff_t>(rows.end)};
}

/* When the rows of a segment were due: as many are early as late. */
std::vector<double> due_times_s(const record &made, stamped_part rows, const std::vector<std::int64_t> &places)
{
    std::vector<double> phases_s;
    for (std::size_t n = rows.begin; n < rows.end; n++) {
        phases_s.push_back(made.time_s[n] - made.period_s * static_cast<double>(places[n - rows.begin]));
    }
    const double phase_s = quantile(phases_s, 0.5);
    std::vector<double> due_s(places.size());
    std::transform(places.begin(), places.end(), due_s.begin(),
                   [&](std::int64_t place) { return phase_s + made.period_s * static_cast<double>(place); });
    return due_s;
}

/* Of a testing machine, whose rows no loop has made: a tick has its own time. Rows that were brought to even times.
 */
std::size_t bring_to_even_times(record &made, stamped_part rows, const std::vector<std::int64_t> &places)
{
    if (!made.command_position_m.empty() || made.has_operator() || made.robot_position_m.empty()) {
        return 0;
    }
    const std::vector<double> stamp_s = part_of(made.time_s, rows);
    const std::vector<double> due_s = due_times_s(made, rows, places);
    if (!are_taken_at_stamps(stamp_s, due_s, part_of(made.robot_position_m, rows))) {
        return 0;
    }
    for (const signal_member &signal : signal_members) {
        std::vector<double> &values = made.*signal.member;
        if (values.size() == made.size()) {
            const std::vector<double> even =
                signal.name == "t_s" ? due_s : at_due_times(stamp_s, due_s, part_of(values, rows));
            std::copy(even.begin(), even.end(), values.begin() + static_cast<std::ptrdiff_t>(rows.begin));
        }
    }
    return rows.end - rows.begin;
}

} // namespace

row_spacing spacing_of(const record &made, const row_marks &marks)
{
    refuse_few_rows(made);
    const double median_s = median_step_s(made);
    row_spacing spacing{{}, parts_of(made, marks)};
    spacing.clock = clock_of(made.time_s, spacing.parts, median_s);
    refuse_drifting_rate(made, spacing);
    return spacing;
}

void check_labels(const record &made, const row_marks &marks, const std::string &column)
{
    std::size_t changes = 0;
    for (std::size_t n = 0; n < marks.labels.size(); n++) {
        if (marks.labels[n] != std::floor(marks.labels[n])) {
            throw input_error(place_of(made, marks, n) + ": " + column + " is " +
                              formatted("%.15g", marks.labels[n]) +
                              "; as `segment` it numbers the parts of a record and is whole");
        }
        changes += n > 0 && marks.labels[n] != marks.labels[n - 1];
    }
    if (2 * changes > made.size()) {
        throw input_error(made.path + ": " + column + " changes in " + std::to_string(changes) + " of " +
                          std::to_string(made.size()) + " rows; as `segment` it numbers the parts of a record");
    }
}

void find_segments(record &made, const std::vector<stamped_part> &parts)
{
    row_findings found;
    std::vector<double> all_places;
    for (const stamped_part &part : parts) {
        const std::vector<std::int64_t> places = places_on_grid(made.time_s, part, made.period_s);
        record_segment segment{part.begin, part.end};
        for (std::size_t n = 0; n < places.size(); n++) {
            all_places.push_back(static_cast<double>(places[n]));
            const std::int64_t left_out = n == 0 ? 0 : places[n] - places[n - 1] - 1;
            if (left_out > missing_rows_max) {
                segment.end = part.begin + n;
                made.segments.push_back(segment);
                segment = {part.begin + n, part.end};
                found.gaps++;
            } else if (left_out > 0) {
                found.missing.push_back({part.begin + n, static_cast<std::size_t>(left_out)});
            }
        }
        made.segments.push_back(segment);
    }
    for (const record_segment &segment : made.segments) {
        const stamped_part rows{segment.begin, segment.end};
        const std::vector<std::int64_t> places = places_on_grid(made.time_s, rows, made.period_s);
        const lateness stamps = lateness_of(made.time_s, rows, places, made.period_s);
        if (stamps.jitter_s > jitter_least * made.period_s || stamps.late > 0) {
            found.at_stamps += bring_to_even_times(made, rows, places);
        }
        found.late += stamps.late;
        found.latest_s = std::max(found.latest_s, stamps.largest_s);
        found.jitter_s = std::max(found.jitter_s, stamps.jitter_s);
    }
    add_notes(made, found);
    fill_in(made, found.missing, all_places);
    find_starts_elsewhere(made);
}

} // namespace berth
