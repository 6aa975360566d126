#include "record_gaps.h"

#include <algorithm>
#include <cmath>

#include "missing_values.h"

namespace berth
{

namespace
{

const record_segment &part_with(const std::vector<record_segment> &parts, std::size_t row)
{
    return *std::upper_bound(parts.begin(), parts.end(), row,
                             [](std::size_t place, const record_segment &one) { return place < one.end; });
}

/* Every row that is there, and before it what `put_in(gap, row)` tells of the missing ones, counted from 1. */
template <typename value, typename told>
std::vector<value> with_missing(const std::vector<value> &read, const std::vector<missing_rows> &missing,
                                const told &put_in)
{
    std::vector<value> made;
    std::size_t next = 0;
    for (std::size_t n = 0; n < read.size(); n++) {
        for (; next < missing.size() && missing[next].before == n; next++) {
            for (std::size_t row = 1; row <= missing[next].count; row++) {
                made.push_back(put_in(missing[next], row));
            }
        }
        made.push_back(read[n]);
    }
    return made;
}

} // namespace

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

void fill_in(record &made, const std::vector<missing_rows> &missing, const std::vector<double> &place)
{
    if (missing.empty()) {
        return;
    }
    for (const auto signal : record_signals) {
        missing_values values(made.*signal, place);
        made.*signal = with_missing(made.*signal, missing, [&](const missing_rows &gap, std::size_t row) {
            return values.at(gap.before, gap.count, row, part_with(made.segments, gap.before));
        });
        if (signal == &record::command_position_m) {
            made.command_guess_rms_m = values.error_rms();
        }
    }
    const std::vector<double> read_s = made.time_s;
    made.time_s = with_missing(read_s, missing, [&](const missing_rows &gap, std::size_t row) {
        const double from_s = read_s[gap.before - 1];
        return from_s +
               (read_s[gap.before] - from_s) / static_cast<double>(gap.count + 1) * static_cast<double>(row);
    });
    made.filled = with_missing(std::vector<std::uint8_t>(read_s.size(), 0), missing,
                               [](const missing_rows &, std::size_t) { return std::uint8_t{1}; });
    for (record_segment &part : made.segments) {
        const record_segment read = part;
        for (const missing_rows &gap : missing) {
            part.begin += gap.before <= read.begin ? gap.count : 0;
            part.end += gap.before < read.end ? gap.count : 0;
        }
    }
}

} // namespace berth
