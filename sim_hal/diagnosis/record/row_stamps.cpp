#include "row_stamps.h"

#include <algorithm>
#include <cmath>

#include "../noise/noise.h"

namespace berth
{

namespace
{

/* Rows that the grid's phase is estimated from: few enough that a period off by a thousandth moves it by a sixtieth
 * of a row. */
constexpr std::size_t phase_rows = 32;

constexpr double alike = 1e-3;       /* rounding and jitter of stamps move the median by less */
constexpr double delay = 0.3;        /* of a step: a delay, and no rounding */
constexpr std::size_t seldom = 1000; /* one step in so many is delayed at least */
constexpr std::size_t few = 50;      /* one step in so many: where delays are, and stamps are not just rounded */

/* Where jitter put a row onto its successor's place, all rows before were moved by one, which looks like a missing
 * row: but then the stamps on both sides lie on the same grid without it. */
void close_false_gaps(const std::vector<double> &time_s, stamped_part part, double period_s,
                      std::vector<std::int64_t> &places)
{
    const auto phase_s = [&](std::size_t begin, std::size_t end) {
        std::vector<double> phases_s;
        for (std::size_t n = begin; n < end; n++) {
            phases_s.push_back(time_s[part.begin + n] - period_s * static_cast<double>(places[n]));
        }
        return median_of(phases_s);
    };
    for (std::size_t n = 1; n < places.size(); n++) {
        const std::int64_t left_out = places[n] - places[n - 1] - 1;
        if (left_out > 0 &&
            phase_s(n - std::min(n, phase_rows), n) - phase_s(n, std::min(n + phase_rows, places.size())) >
                0.5 * period_s * static_cast<double>(left_out)) {
            std::for_each(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(n),
                          [&](std::int64_t &place) { place += left_out; });
        }
    }
}

} // namespace

std::vector<std::int64_t> places_on_grid(const std::vector<double> &time_s, stamped_part part, double period_s)
{
    /* Of the last rows, a stamp less its place on the grid; of the first ones, as if no row among them were missing:
     * that moves it by whole periods only. */
    std::vector<double> phases_s;
    for (std::size_t n = part.begin; n < std::min(part.begin + phase_rows, part.end); n++) {
        phases_s.push_back(time_s[n] - period_s * static_cast<double>(n - part.begin));
    }
    std::fill(phases_s.begin(), phases_s.end(), median_of(phases_s));
    std::vector<std::int64_t> places;
    for (std::size_t n = part.begin; n < part.end; n++) {
        places.push_back(std::llround((time_s[n] - median_of(phases_s)) / period_s));
        phases_s[(n - part.begin) % phases_s.size()] = time_s[n] - period_s * static_cast<double>(places.back());
    }
    for (std::size_t n = places.size() - 1; n > 0; n--) {
        places[n - 1] = std::min(places[n - 1], places[n] - 1);
    }
    close_false_gaps(time_s, part, period_s, places);
    const std::int64_t first = places.front();
    std::for_each(places.begin(), places.end(), [&](std::int64_t &place) { place -= first; });
    return places;
}

namespace
{

/* Over so many rows jitter and rounding average out, and few rows are missing. */
double step_of_many_rows_s(const std::vector<double> &time_s, const std::vector<stamped_part> &parts,
                           double median_step_s)
{
    constexpr std::size_t apart = 16;
    std::vector<double> steps_s;
    for (const stamped_part &part : parts) {
        for (std::size_t n = part.begin; n + apart < part.end; n++) {
            steps_s.push_back((time_s[n + apart] - time_s[n]) / static_cast<double>(apart));
        }
    }
    return steps_s.empty() ? median_step_s : median_of(steps_s);
}

double slope_of_line_s(const std::vector<double> &time_s, const std::vector<stamped_part> &parts, double period_s)
{
    double times_places = 0.0;
    double squares = 0.0;
    for (const stamped_part &part : parts) {
        const std::vector<std::int64_t> places = places_on_grid(time_s, part, period_s);
        double mean_place = 0.0;
        for (const std::int64_t place : places) {
            mean_place += static_cast<double>(place) / static_cast<double>(places.size());
        }
        for (std::size_t n = part.begin; n < part.end; n++) {
            const double from_mean = static_cast<double>(places[n - part.begin]) - mean_place;
            times_places += from_mean * (time_s[n] - time_s[part.begin]);
            squares += from_mean * from_mean;
        }
    }
    return squares > 0.0 ? times_places / squares : period_s;
}

/* Half of the steps or more are the median, hardly one is shorter, and some are so much longer as no rounding makes
 * them. */
bool has_usual_step(const std::vector<double> &time_s, const std::vector<stamped_part> &parts, double median_step_s)
{
    std::size_t usual = 0;
    std::size_t shorter = 0;
    std::size_t delayed = 0;
    std::size_t steps = 0;
    for (const stamped_part &part : parts) {
        for (std::size_t n = part.begin + 1; n < part.end; n++) {
            const double longer_s = time_s[n] - time_s[n - 1] - median_step_s;
            usual += std::abs(longer_s) <= alike * median_step_s;
            shorter += longer_s < -alike * median_step_s;
            delayed += longer_s > delay * median_step_s;
            steps++;
        }
    }
    return 2 * usual >= steps && few * shorter <= steps && seldom * delayed >= steps;
}

} // namespace

row_clock clock_of(const std::vector<double> &time_s, const std::vector<stamped_part> &parts, double median_step_s)
{
    const double first_s = slope_of_line_s(time_s, parts, step_of_many_rows_s(time_s, parts, median_step_s));
    return {slope_of_line_s(time_s, parts, first_s), median_step_s, has_usual_step(time_s, parts, median_step_s)};
}

lateness lateness_of(const std::vector<double> &time_s, stamped_part part, const std::vector<std::int64_t> &places,
                     double period_s)
{
    std::vector<double> phases_s;
    for (std::size_t n = part.begin; n < part.end; n++) {
        phases_s.push_back(time_s[n] - period_s * static_cast<double>(places[n - part.begin]));
    }
    lateness found{0, 0.0, 0.0};
    for (std::size_t n = 0; n < phases_s.size(); n++) {
        const auto begin = phases_s.begin() + static_cast<std::ptrdiff_t>(n - std::min(n, phase_rows / 2));
        const auto end =
            phases_s.begin() + static_cast<std::ptrdiff_t>(std::min(n + phase_rows / 2, phases_s.size()));
        const double late_s = phases_s[n] - median_of({begin, end});
        if (late_s > 0.25 * period_s) {
            found.late++;
            found.largest_s = std::max(found.largest_s, late_s);
        } else {
            found.jitter_s = std::max(found.jitter_s, std::abs(late_s));
        }
    }
    return found;
}

} // namespace berth
