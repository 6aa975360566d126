#include "clock_slips.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clock_ways.h"
#include "slip_table.h"

namespace berth
{

namespace
{

/* One tick off leaves a stiff contact's whole answer: no tick may be passed over. */
constexpr slip_search of_force = {150.0, 1.0, 0.2};
constexpr slip_search of_force_closely = {3.0, 0.25, 0.2};
/* Reports show a slip by the way of one tick, which is none where the robot turns back. */
constexpr slip_search of_reports = {240.0, 4.0, 0.05};
constexpr slip_search of_reports_closely = {8.0, 0.5, 0.05};
constexpr slip_search to_be_sure = {150.0, 1.0, 0.05};

} // namespace

void wrap_clock_phase(rig &rig, double period_s)
{
    const double period_ms = 1e3 * period_s;
    double &phase_ms = rig.robot.clock_phase_ms;
    phase_ms -= period_ms * std::floor(phase_ms / period_ms);
    phase_ms = phase_ms < period_ms ? phase_ms : 0.0; /* what was a rounding below 0 */
}

std::vector<row_use> uses_beside_slips(const block_model &model, const rig &rig)
{
    std::vector<row_use> uses = model.uses();
    for (const record_segment &answer : answers_to_slips(rig, model.data(), of_force).rows) {
        std::fill(uses.begin() + static_cast<std::ptrdiff_t>(answer.begin),
                  uses.begin() + static_cast<std::ptrdiff_t>(answer.end), row_use::none);
    }
    return uses;
}

namespace
{

/* Moves drift and phase of the fitted rig so that the slips fall where the block shows them. */
void put_slips_in_place(block_model &model, fit_result &fitted, const slip_search &search)
{
    constexpr int rounds = 5;
    bool leads_on = true;
    for (int round = 0; round < rounds && leads_on; round++) {
        const slip_answers slips = answers_to_slips(fitted.rig, model.data(), search);
        if (slips.rows.empty()) {
            return;
        }
        const clock_ways ways(fitted, model.data());
        const slip_table table(model, fitted.rig, slips, search.ticks_step, ways);
        leads_on = table.apply_best(fitted.rig, ways);
    }
}

using clock_way = void (clock_ways::*)(rig &, double) const;

/* Rises of the white sum of squares that 95 % allow: of a slope, and of a place where the error changes (Hansen,
 * Sample splitting and threshold estimation, Econometrica 2000, table I). */
constexpr double rise_of_slope = 3.84;
constexpr double rise_of_place = 7.35;

double excess_of(const fit_result &fitted)
{
    return std::max(1.0, fitted.cost / static_cast<double>(fitted.rows));
}

void know_alone(Eigen::MatrixXd &correlation, Eigen::Index i)
{
    if (i < correlation.rows()) {
        correlation.row(i).setZero();
        correlation.col(i).setZero();
        correlation(i, i) = 1.0;
    }
}

/* How far a rig may be moved either way until the white sum of squares has risen by what 95 % allow. */
double reach(block_model &model, const noise_model &noise, const fit_result &fitted, double step,
             const clock_ways &ways, clock_way way)
{
    constexpr int doublings = 24;
    const double rise_max = rise_of_slope * excess_of(fitted);
    const double least = cost_of(model, noise, fitted.rig);
    double by = step;
    for (int i = 0; i < doublings; i++) {
        double rise = unlimited;
        for (const double sign : {-1.0, 1.0}) {
            rig moved = fitted.rig;
            (ways.*way)(moved, sign * by);
            rise = std::min(rise, cost_of(model, noise, moved) - least);
        }
        if (rise > rise_max) {
            break;
        }
        by *= 2.0;
    }
    return by;
}

} // namespace

void match_slips(block_model &force, fit_result &fitted)
{
    put_slips_in_place(force, fitted, of_force);
    put_slips_in_place(force, fitted, of_force_closely);
}

namespace
{

/* Goes by turns and shifts until none leads on. */
void polish(block_model &model, const noise_model &noise, fit_result &fitted)
{
    constexpr int rounds = 40;
    double turn_ppm = 0.05 * std::abs(fitted.rig.robot.clock_drift_ppm);
    double shift_ms = 0.02 * 1e3 * model.data().period_s;
    fitted.cost = cost_of(model, noise, fitted.rig);
    for (int round = 0; round < rounds; round++) {
        const clock_ways ways(fitted, model.data());
        if (!ways.has_slips) {
            return;
        }
        bool any = false;
        for (const auto &[way, by] : {std::pair<clock_way, double>{&clock_ways::turn, turn_ppm},
                                      {&clock_ways::turn, -turn_ppm},
                                      {&clock_ways::shift, shift_ms},
                                      {&clock_ways::shift, -shift_ms}}) {
            rig moved = fitted.rig;
            (ways.*way)(moved, by);
            const double cost = cost_of(model, noise, moved);
            if (cost < fitted.cost) {
                fitted.cost = cost;
                fitted.rig = moved;
                any = true;
            }
        }
        turn_ppm *= any ? 1.0 : 0.4;
        shift_ms *= any ? 1.0 : 0.4;
    }
}

} // namespace

void polish_clock(block_model &model, const noise_model &noise, fit_result &fitted)
{
    fit_result matched = fitted;
    put_slips_in_place(model, matched, of_reports);
    put_slips_in_place(model, matched, of_reports_closely);
    polish(model, noise, fitted);
    polish(model, noise, matched);
    if (matched.cost < fitted.cost) {
        fitted.rig = matched.rig;
        fitted.cost = matched.cost;
    }
}

void widen_clock_intervals(block_model &model, const noise_model &noise, fit_result &fitted)
{
    const clock_ways ways(fitted, model.data());
    if (!ways.has_slips || fitted.ci95.size() != fitted.parameters.size()) {
        return; /* then the error is smooth in both */
    }
    const double turn_ppm =
        reach(model, noise, fitted, 1e-6 * std::abs(fitted.rig.robot.clock_drift_ppm), ways, &clock_ways::turn);
    const double shift_ms =
        reach(model, noise, fitted, 1e-6 * 1e3 * model.data().period_s, ways, &clock_ways::shift);
    slip_table::width width{turn_ppm, std::hypot(shift_ms, 1e-3 * turn_ppm * ways.pivot_s)};
    const slip_answers slips = answers_to_slips(fitted.rig, model.data(), to_be_sure);
    if (!slips.rows.empty()) {
        const double rise_max = rise_of_place * excess_of(fitted) * noise.rms * noise.rms;
        const slip_table table(model, fitted.rig, slips, to_be_sure.ticks_step, ways);
        const slip_table::width elsewhere = table.within(rise_max);
        width = {std::max(width.drift_ppm, elsewhere.drift_ppm), std::max(width.phase_ms, elsewhere.phase_ms)};
    }
    for (std::size_t i = 0; i < fitted.parameters.size(); i++) {
        const std::string_view key = fitted.parameters[i].key->path;
        const bool is_drift = key == "robot.clock_drift_ppm";
        if (is_drift || key == "robot.clock_phase_ms") {
            fitted.ci95[i] = std::max(fitted.ci95[i], is_drift ? width.drift_ppm : width.phase_ms);
            know_alone(fitted.correlation, static_cast<Eigen::Index>(i));
        }
    }
}

} // namespace berth
