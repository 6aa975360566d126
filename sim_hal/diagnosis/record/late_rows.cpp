#include "late_rows.h"

namespace berth
{

namespace
{

/* These rows alone. */
void keep_rows(record &data, const std::vector<std::size_t> &rows)
{
    const auto keep = [&](auto &values) {
        for (std::size_t i = 0; !values.empty() && i < rows.size(); i++) {
            values[i] = values[rows[i]];
        }
        values.resize(std::min(values.size(), rows.size()));
    };
    for (const auto signal : record_signals) {
        keep(data.*signal);
    }
    keep(data.time_s);
    keep(data.bend_m_per_s2);
    keep(data.filled);
}

} // namespace

record with_column_in_place(record data, std::vector<double> record::*column, int late_rows)
{
    if (late_rows == 0 || (data.*column).empty()) {
        return data;
    }
    const std::vector<double> as_logged = data.*column;
    std::vector<double> &values = data.*column;
    const std::size_t lost = late_rows > 0 ? static_cast<std::size_t>(late_rows) : 0;
    std::vector<std::size_t> rows;
    std::vector<record_segment> parts;
    for (const record_segment &part : data.segments) {
        const std::size_t end = part.end - std::min(lost, part.end - part.begin);
        for (std::size_t n = part.begin; n < end; n++) {
            const std::ptrdiff_t before = late_rows + static_cast<std::ptrdiff_t>(n - part.begin);
            values[n] = as_logged[part.begin + static_cast<std::size_t>(std::max<std::ptrdiff_t>(before, 0))];
            rows.push_back(n);
        }
        if (end > part.begin) {
            parts.push_back({rows.size() - (end - part.begin), rows.size(), part.stands_m});
        }
    }
    keep_rows(data, rows);
    data.segments = std::move(parts);
    return data;
}

} // namespace berth
