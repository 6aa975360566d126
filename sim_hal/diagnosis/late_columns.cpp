#include "late_columns.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "../effects/effects.h"
#include "decide/criteria.h"
#include "described.h"
#include "fit/base.h"
#include "fit/gain.h"
#include "noise/floor.h"
#include "record/late_rows.h"
#include "record/motion_noise.h"
#include "search/acceptance.h"

namespace berth
{

namespace
{

/* What a logger writes late, with the two blocks that tell: the one that it comes out of, and another. */
struct column {
    std::string_view name; /* of the cause */
    std::string_view signal;
    std::vector<double> record::*member;
    block output;
    block witness;
    bool drives_witness; /* else the witness says whether the robot itself is as late */
};

constexpr column columns[] = {
    {"log.force_late", "force_N", &record::force_N, block::force, block::manipulator, true},
    {"log.robot_position_late", "robot_position_m", &record::robot_position_m, block::robot, block::force, false},
    {"log.command_late", "command_position_m", &record::command_position_m, block::manipulator, block::robot, true},
};

const effect *told_as(std::string_view name)
{
    static const std::array<effect, std::size(columns)> made = [] {
        std::array<effect, std::size(columns)> all{};
        for (std::size_t i = 0; i < all.size(); i++) {
            all[i].name = columns[i].name;
            all[i].physics = "No physics: the column stands rows below the ones where its values belong.";
        }
        return all;
    }();
    return &*std::find_if(made.begin(), made.end(), [&](const effect &one) { return one.name == name; });
}

/* A record to fit, and one to look at with what was fitted. */
struct pair_of_records {
    record fit;
    std::optional<record> unseen;
};

pair_of_records moved(const pair_of_records &data, const column &one, int rows)
{
    pair_of_records made = data;
    made.fit = with_column_in_place(std::move(made.fit), one.member, rows);
    if (made.unseen) {
        made.unseen = with_column_in_place(std::move(*made.unseen), one.member, rows);
    }
    return made;
}

/* Squares of the error over the rows that count. */
std::vector<double> squares_of(block which, const record &data, const rig &given, const rig &rig)
{
    const sample_events none;
    block_model model(which, data, given, none, held_out_parts::none);
    std::vector<double> error;
    model.error(rig, error);
    std::vector<double> squares;
    for (std::size_t n = 0; n < error.size(); n++) {
        if (model.uses()[n] == row_use::fit) {
            squares.push_back(error[n] * error[n] + std::pow(model.rounding_rms(), 2));
        }
    }
    return squares;
}

double mean_of(const std::vector<double> &values)
{
    double sum = 0.0;
    for (const double value : values) {
        sum += value;
    }
    return values.empty() ? 1e-300 : std::max(sum / static_cast<double>(values.size()), 1e-300);
}

/* The base, or with one more parameter free, from `start`. */
rig fitted(block which, const record &data, const rig &given, const rig &start,
           const std::vector<free_parameter> &more)
{
    constexpr int replays_max = 120;
    const sample_events none;
    block_model model(which, data, given, none, held_out_parts::none);
    std::vector<double> error;
    model.error(start, error);
    return fit(model, noise_of(model, error, true), start, joined(base_parameters(which, given), more), replays_max)
        .rig;
}

/* How a block sees the records, the base fitted to the first one. */
struct look {
    berth::rig rig;
    std::vector<double> of_fit;    /* squares */
    std::vector<double> of_unseen; /* empty: there is none */
};

look look_at(block which, const pair_of_records &data, const rig &given, const rig &start,
             const std::vector<free_parameter> &more = {})
{
    look made{fitted(which, data.fit, given, start, more), {}, {}};
    made.of_fit = squares_of(which, data.fit, given, made.rig);
    if (data.unseen && can_replay(*data.unseen, which)) {
        made.of_unseen = squares_of(which, *data.unseen, given, made.rig);
    }
    return made;
}

/* BIC of two models with as many parameters. */
double better_by(const look &after, const look &before)
{
    const auto of = [](const std::vector<double> &a, const std::vector<double> &b) {
        return static_cast<double>(std::min(a.size(), b.size())) * std::log(mean_of(b) / mean_of(a));
    };
    const double sum = of(after.of_fit, before.of_fit) + of(after.of_unseen, before.of_unseen);
    return std::isfinite(sum) ? sum : -unlimited;
}

/* Where a block by itself sees the least error between the rows next to this number, as a parabola through them. */
struct place {
    double rows;
    double ci95;
};

place least_error(block which, const pair_of_records &data, const column &one, int rows, const rig &given,
                  const rig &rig)
{
    std::array<double, 3> squares{};
    std::size_t count = 0;
    for (std::size_t n = 0; n < squares.size(); n++) {
        const int beside = static_cast<int>(n) - 1;
        const std::vector<double> all =
            squares_of(which, with_column_in_place(data.fit, one.member, rows + beside), given, rig);
        squares[n] = mean_of(all);
        count = all.size();
    }
    const double bend = squares[0] - 2.0 * squares[1] + squares[2];
    if (!(bend > 0.0)) {
        return {unlimited, unlimited};
    }
    const double off = 0.5 * (squares[0] - squares[2]) / bend;
    return {static_cast<double>(rows) + off,
            1.96 * std::sqrt(2.0 * squares[1] / (bend * static_cast<double>(std::max<std::size_t>(count, 1))))};
}

bool can_tell(const pair_of_records &data, const rig &given, block which)
{
    return can_replay(data.fit, which) && !(which == block::force && given.has_wandering_samples()) &&
           missing_section(data.fit, given, which).empty();
}

std::vector<block> driven_by(const column &one)
{
    return one.drives_witness ? std::vector<block>{one.output, one.witness} : std::vector<block>{one.output};
}

/* Moves the column row by row while the blocks that it drives get better. The base is fitted anew each time. A base
 * that is not fitted can hide a shift of a few rows; one that was fitted to the late column hides it. */
int most_promising(const pair_of_records &data, const column &one, const rig &given)
{
    std::vector<look> as_logged;
    for (const block which : driven_by(one)) {
        as_logged.push_back(look_at(which, data, given, given));
    }
    const auto better_after = [&](int rows) {
        const pair_of_records tried = moved(data, one, rows);
        double sum = 0.0;
        for (std::size_t i = 0; i < as_logged.size(); i++) {
            sum += better_by(look_at(driven_by(one)[i], tried, given, given), as_logged[i]);
        }
        return sum;
    };
    int best = 0;
    double most = 0.0;
    for (const int step : {1, -1}) {
        for (int rows = step; best == rows - step && std::abs(rows) <= criteria::late_rows_max; rows += step) {
            const double better = better_after(rows);
            if (better > most) {
                most = better;
                best = rows;
            }
        }
        if (best != 0) {
            break;
        }
    }
    return best;
}

/* A column that is late and nothing else leaves what its noise and its steps make. What a filter smears over rows,
 * or another fault beside it, leaves more. */
bool leaves_noise(const look &in_place, const pair_of_records &data, const column &one, const rig &given)
{
    const double noise = noise_from_row_to_row(data.fit, data.fit.*one.member);
    const sample_events none;
    const block_model model(one.output, data.fit, given, none, held_out_parts::none);
    /* Twice: squares_of() adds it to an error that has it already. */
    const double least = std::pow(noise, 2) + 2.0 * std::pow(model.rounding_rms(), 2);
    return mean_of(in_place.of_fit) <= criteria::unseen_far * least;
}

/* Of the witness that this column does not drive: how much worse a robot that is itself so late makes all. */
double robot_is_worse_by(const pair_of_records &data, const column &one, int rows, const rig &given,
                         const look &as_logged, const look &in_place)
{
    const effect &dead_time = *find_effect("robot.dead_time");
    rig late = given;
    late.robot.dead_time_ms = std::max(0.0, late.robot.dead_time_ms + 1e3 * rows * data.fit.period_s);
    const look reports = look_at(one.output, data, given, late, effect_parameters(dead_time, late));
    const look force = look_at(one.witness, data, given, given);
    const look force_behind = look_at(one.witness, data, given, reports.rig);
    return better_by(in_place, as_logged) - better_by(reports, as_logged) - better_by(force_behind, force);
}

gain gain_of(const std::vector<double> &before, const std::vector<double> &after, double period_s)
{
    const auto length = std::max<std::size_t>(5, static_cast<std::size_t>(0.1 / period_s));
    paired_sums sums;
    for (std::size_t begin = 0; begin + length <= std::min(before.size(), after.size()); begin += length) {
        const auto sum = [&](const std::vector<double> &squares) {
            double all = 0.0;
            for (std::size_t n = begin; n < begin + length; n++) {
                all += squares[n];
            }
            return all;
        };
        sums.before.push_back(sum(before));
        sums.after.push_back(sum(after));
    }
    return gain_from(sums);
}

std::optional<late_column> find_late(const pair_of_records &data, const column &one, const rig &given)
{
    if ((data.fit.*one.member).empty() || !can_tell(data, given, one.output) ||
        !can_tell(data, given, one.witness)) {
        return {};
    }
    const int rows = most_promising(data, one, given);
    if (rows == 0 || std::abs(rows) == criteria::late_rows_max) {
        return {};
    }
    const pair_of_records in_place = moved(data, one, rows);
    late_column made{told_as(one.name), one.signal, one.output, rows, 0.0, 0.0, {}, {}, 0.0, 0.0, 0.0};
    look before;
    look after;
    for (const block which : driven_by(one)) {
        const look as_logged = look_at(which, data, given, given);
        const look now = look_at(which, in_place, given, given);
        const double better = better_by(now, as_logged);
        const place least = least_error(which, data, one, rows, given, now.rig);
        const double off = std::abs(least.rows - rows);
        if (better < bic_clear || !(off < criteria::late_rows_whole)) {
            return {};
        }
        made.delta_bic += better;
        made.uncertain_rows = std::max({made.uncertain_rows, off, least.ci95});
        if (which == one.output) {
            if (!leaves_noise(now, in_place, one, given)) {
                return {};
            }
            before = as_logged;
            after = now;
        }
    }
    const double sure =
        one.drives_witness ? made.delta_bic : robot_is_worse_by(data, one, rows, given, before, after);
    if (sure < bic_beyond_doubt) {
        return {};
    }
    const std::vector<double> &unseen = before.of_unseen.empty() ? before.of_fit : before.of_unseen;
    const gain gained = gain_of(unseen, after.of_unseen.empty() ? after.of_fit : after.of_unseen, data.fit.period_s);
    made.fit_rms.before = std::sqrt(mean_of(squares_of(one.output, data.fit, given, given)));
    made.fit_rms.retuned = std::sqrt(mean_of(before.of_fit));
    made.held_out_rms.retuned = std::sqrt(mean_of(unseen));
    made.held_out_rms.before = before.of_unseen.empty()
                                   ? made.fit_rms.before
                                   : std::sqrt(mean_of(squares_of(one.output, *data.unseen, given, given)));
    made.gain = gained.value;
    made.gain_low = gained.low;
    made.gain_high = gained.high;
    return made;
}

} // namespace

std::vector<late_column> put_late_columns_in_place(records_of_request &records)
{
    std::vector<late_column> found;
    if (records.fit.header_line == 0 || records.fit.is_from_this_firmware) {
        return found; /* a log of ours */
    }
    pair_of_records data{records.fit, records.validation};
    for (std::size_t round = 0; round < std::size(columns); round++) {
        std::optional<late_column> best;
        const column *which = nullptr;
        for (const column &one : columns) {
            auto late = find_late(data, one, records.replayed);
            if (late && (!best || late->delta_bic > best->delta_bic)) {
                best = late;
                which = &one;
            }
        }
        if (!best) {
            break;
        }
        data = moved(data, *which, best->rows);
        for (std::optional<record> *const beside : {&records.standstill, &records.repetition}) {
            if (*beside) {
                **beside = with_column_in_place(std::move(**beside), which->member, best->rows);
            }
        }
        found.push_back(*best);
    }
    records.fit = std::move(data.fit);
    records.validation = std::move(data.unseen);
    return found;
}

void tell_late_columns(diagnosis &result, const std::vector<late_column> &late)
{
    for (const late_column &one : late) {
        const auto block = std::find_if(result.blocks.begin(), result.blocks.end(),
                                        [&](const block_diagnosis &each) { return each.block == one.block; });
        if (block == result.blocks.end()) {
            continue;
        }
        const double row_ms = 1e3 * result.data.period_s;
        cause made;
        made.effect = one.told_as;
        made.parameters = {
            {std::string(one.told_as->name) + "_rows", static_cast<double>(one.rows), one.uncertain_rows},
            {std::string(one.told_as->name) + "_ms", one.rows * row_ms, one.uncertain_rows * row_ms}};
        made.delta_bic = one.delta_bic;
        const double floor = std::pow(block->floor.rms, 2);
        const double explainable = std::pow(one.fit_rms.retuned, 2) - floor;
        made.share_explained =
            std::clamp((explainable + floor - std::pow(block->fit_rms.retuned, 2)) / explainable, 0.0, 1.0);
        made.held_out_gain = one.gain;
        made.held_out_gain_low = one.gain_low;
        made.held_out_gain_high = one.gain_high;
        block->causes.insert(block->causes.begin(), made);
        block->fit_rms.before = one.fit_rms.before;
        block->fit_rms.retuned = one.fit_rms.retuned;
        block->held_out_rms.before = one.held_out_rms.before;
        block->held_out_rms.retuned = one.held_out_rms.retuned;
        block->verdict = block->verdict == verdict::nothing_detectable ? verdict::named
                         : block->verdict == verdict::unknown          ? verdict::partly_explained
                                                                       : block->verdict;
        const int rows = std::abs(one.rows);
        result.notes.push_back(std::string(one.signal) + " stands " + std::to_string(rows) +
                               (rows == 1 ? " row " : " rows ") + (one.rows > 0 ? "below" : "above") +
                               " where it belongs, as two blocks show; the rest of this answer is about the record "
                               "with the column moved " +
                               (one.rows > 0 ? "up" : "down") +
                               " by as many rows: mend the logger, or move it there");
    }
}

} // namespace berth
