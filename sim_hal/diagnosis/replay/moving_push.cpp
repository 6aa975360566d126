#include "moving_push.h"

#include <algorithm>
#include <cmath>

#include "../formatted.h"
#include "../search/acceptance.h"

namespace berth
{

namespace
{

/* A sinc under Kaiser's window: what has less than 0.84 of the highest frequency is followed to 1e-4. */
constexpr std::ptrdiff_t rows_aside = 16;
constexpr double kaiser_beta = 8.0;

double kernel(double rows_away)
{
    const double angle = M_PI * rows_away;
    const double place = rows_away / static_cast<double>(rows_aside);
    const double window = std::cyl_bessel_i(0.0, kaiser_beta * std::sqrt(std::max(0.0, 1.0 - place * place)));
    return window * (std::abs(angle) < 1e-9 ? 1.0 : std::sin(angle) / angle);
}

/* The push at a row, of a segment that goes on beyond its ends as if turned about them. */
double push_at(const record &record, const record_segment &segment, std::ptrdiff_t row)
{
    const auto first = static_cast<std::ptrdiff_t>(segment.begin);
    const auto last = static_cast<std::ptrdiff_t>(segment.end) - 1;
    const auto measured = [&](std::ptrdiff_t at) {
        const auto n = static_cast<std::size_t>(std::clamp(at, first, last));
        return (record.operator_force_N.empty() ? 0.0 : record.operator_force_N[n]) -
               (record.force_N.empty() ? 0.0 : record.force_N[n]);
    };
    if (row < first) {
        return 2.0 * measured(first) - measured(2 * first - row);
    }
    return row > last ? 2.0 * measured(last) - measured(2 * last - row) : measured(row);
}

/* Root mean square of the changes from row to row, of the standard deviation. */
double change_from_row_to_row(const std::vector<double> &force_N)
{
    double sum = 0.0;
    double square = 0.0;
    double steps = 0.0;
    for (std::size_t n = 0; n < force_N.size(); n++) {
        const double step = n == 0 ? 0.0 : force_N[n] - force_N[n - 1];
        sum += force_N[n];
        square += force_N[n] * force_N[n];
        steps += step * step;
    }
    const auto rows = static_cast<double>(force_N.size());
    return std::sqrt(steps / std::max(square - sum * sum / rows, 1e-300));
}

/* A push that is held is late by half a row, and what it moves with it: so far, rms, without the noise. */
double half_a_row_m(const record &data, double noise_m)
{
    double square = 0.0;
    double steps = 0.0;
    for (const record_segment &part : data.segments) {
        for (std::size_t n = part.begin + 1; n < part.end; n++) {
            square += std::pow(data.command_position_m[n] - data.command_position_m[n - 1], 2);
            steps += 1.0;
        }
    }
    return 0.5 * std::sqrt(std::max(0.0, square / std::max(steps, 1.0) - 2.0 * noise_m * noise_m));
}

std::size_t parameters_of(const block_diagnosis &found)
{
    std::size_t count = 0;
    for (const cause &one : found.causes) {
        count += one.parameters.size();
    }
    return count;
}

/* By BIC over the rows of the fit, and on data that the fit never saw. */
bool explains_more(const block_diagnosis &moving, const block_diagnosis &held)
{
    const auto rows = static_cast<double>(std::count(held.uses.begin(), held.uses.end(), row_use::fit));
    const double gain = 2.0 * rows * std::log(held.fit_rms.after / std::max(moving.fit_rms.after, 1e-300));
    const double parameters = static_cast<double>(parameters_of(moving)) - static_cast<double>(parameters_of(held));
    return gain - parameters * std::log(rows) > bic_undecided && moving.held_out_rms.after < held.held_out_rms.after;
}

bool is_open(const block_diagnosis &found)
{
    return found.verdict == verdict::partly_explained || found.verdict == verdict::unknown;
}

/* `record.push_within_rows_N`, through its rows as the band-limited signal goes that they are samples of. */
void let_push_move(record &record)
{
    double weight[pushes_a_row][2 * rows_aside];
    for (int part = 0; part < pushes_a_row; part++) {
        const double middle = (part + 0.5) / pushes_a_row;
        double sum = 0.0;
        for (std::ptrdiff_t i = 0; i < 2 * rows_aside; i++) {
            weight[part][i] = kernel(middle - static_cast<double>(i - rows_aside + 1));
            sum += weight[part][i];
        }
        for (double &one : weight[part]) {
            one /= sum;
        }
    }
    record.push_within_rows_N.assign(record.size() * pushes_a_row, 0.0);
    for (const record_segment &segment : record.segments) {
        for (std::size_t n = segment.begin; n < segment.end; n++) {
            for (int part = 0; part < pushes_a_row; part++) {
                double &push_N = record.push_within_rows_N[n * pushes_a_row + static_cast<std::size_t>(part)];
                for (std::ptrdiff_t i = 0; i < 2 * rows_aside; i++) {
                    const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(n) + i - rows_aside + 1;
                    push_N += weight[part][i] * push_at(record, segment, row);
                }
            }
        }
    }
}

} // namespace

block_diagnosis better_of_held_and_moving(block_diagnosis held, record &data, std::optional<record> &validation,
                                          const manipulator_work &again, std::vector<std::string> &notes)
{
    constexpr double much = 0.08; /* a drive logged at 1 kHz has 0.04, at 100 Hz 0.33 */
    const double change = change_from_row_to_row(data.operator_force_N);
    const bool may_show = is_open(held) && half_a_row_m(data, held.floor.rms) > held.floor.rms;
    if (data.operator_force_N.empty() || !(change > much || may_show)) {
        return held;
    }
    const auto hold = [&] {
        data.push_within_rows_N.clear();
        if (validation) {
            validation->push_within_rows_N.clear();
        }
    };
    const double held_cost = change > much ? 0.0 : again.refit(held);
    let_push_move(data);
    if (!(change > much) && !(again.refit(held) < held_cost - bic_undecided)) {
        hold();
        return held;
    }
    if (validation) {
        let_push_move(*validation);
    }
    block_diagnosis moving = again.diagnose();
    const bool moves = explains_more(moving, held);
    if (!moves) {
        hold();
    }
    const std::string told = formatted(
        "operator_force_N changes by %.2g of its standard deviation from row to row, and counts as ", change);
    if (moves) {
        notes.push_back(told +
                        formatted("moving on between them: held, it would leave %.3g m rms ", held.fit_rms.after) +
                        formatted("instead of %.3g", moving.fit_rms.after));
    } else if (is_open(held)) {
        notes.push_back(told + "held in between: if it was not, errors of the manipulator's sizes exceed their "
                               "intervals; log it at a higher rate");
    }
    if (moves && is_open(moving)) {
        notes.push_back("what operator_force_N does between its rows is a guess: log it at a higher rate");
    }
    return moves ? std::move(moving) : std::move(held);
}

} // namespace berth
