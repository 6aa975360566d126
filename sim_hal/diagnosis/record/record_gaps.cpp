#include "record_gaps.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

/* Of the command at 400 Hz, a cubic over so many rows misses a 3 Hz motion by 2e-5 of it. */
constexpr double missing_max = 4.0;

/* The place of each row among evenly spaced ones: stamps may jitter, the loop did not. */
std::vector<double> places_of(const record &read)
{
    std::vector<double> place(read.size(), 0.0);
    for (std::size_t n = 1; n < place.size(); n++) {
        const double periods = (read.time_s[n] - read.time_s[n - 1]) / read.period_s;
        place[n] = place[n - 1] + std::max(1.0, std::round(periods));
    }
    return place;
}

/* Lagrange's polynomial through rows `first` up to `last`. */
double interpolated(const std::vector<double> &place, const std::vector<double> &values, std::size_t first,
                    std::size_t last, double at)
{
    double sum = 0.0;
    for (std::size_t i = first; i <= last; i++) {
        double weight = 1.0;
        for (std::size_t j = first; j <= last; j++) {
            weight *= i == j ? 1.0 : (at - place[j]) / (place[i] - place[j]);
        }
        sum += weight * values[i];
    }
    return sum;
}

} // namespace

std::optional<std::size_t> rows_left_out(double step_s, double period_s)
{
    constexpr double jitter = 0.45; /* of the period */
    const double rows = std::round(step_s / period_s) - 1.0;
    if (rows < 1.0 || rows > missing_max || std::abs(step_s / period_s - rows - 1.0) > jitter) {
        return {};
    }
    return static_cast<std::size_t>(rows);
}

std::vector<double> record::known(const std::vector<double> &signal) const
{
    if (filled.empty()) {
        return signal;
    }
    std::vector<double> made;
    for (std::size_t n = 0; n < signal.size(); n++) {
        if (filled[n] == 0) {
            made.push_back(signal[n]);
        }
    }
    return made;
}

std::vector<record_segment> known_stretches(const record &record, const record_segment &segment)
{
    std::vector<record_segment> stretches;
    for (std::size_t n = segment.begin; n < segment.end; n++) {
        if (record.is_filled(n)) {
            continue;
        }
        if (n == segment.begin || record.is_filled(n - 1)) {
            stretches.push_back(segment);
            stretches.back().begin = n;
        }
        stretches.back().end = n + 1;
    }
    return stretches;
}

void fill_in(record &made, const std::vector<missing_rows> &missing)
{
    if (missing.empty()) {
        return;
    }
    const record read = made;
    const std::vector<double> place = places_of(read);
    for (record_segment &part : made.segments) {
        for (const missing_rows &gap : missing) {
            part.begin += gap.before <= part.begin ? gap.count : 0;
            part.end += gap.before < part.end ? gap.count : 0;
        }
    }
    made.filled.assign(read.size(), 0);
    for (auto gap = missing.rbegin(); gap != missing.rend(); ++gap) {
        const std::size_t before = gap->before;
        const std::size_t first = before > 1 ? before - 2 : before - 1;
        const std::size_t last = std::min(before + 1, read.size() - 1);
        const double from_s = read.time_s[before - 1];
        const double step_s = (read.time_s[before] - from_s) / static_cast<double>(gap->count + 1);
        const auto at = static_cast<std::ptrdiff_t>(before);
        for (std::size_t i = gap->count; i >= 1; i--) {
            const auto rows = static_cast<double>(i);
            const double at_s = from_s + step_s * rows;
            for (const auto signal : record_signals) {
                if (!(read.*signal).empty()) {
                    (made.*signal)
                        .insert((made.*signal).begin() + at,
                                interpolated(place, read.*signal, first, last, place[before - 1] + rows));
                }
            }
            made.time_s.insert(made.time_s.begin() + at, at_s);
            made.filled.insert(made.filled.begin() + at, 1);
        }
    }
}

} // namespace berth
