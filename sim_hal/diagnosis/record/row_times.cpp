#include "row_times.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace berth
{

namespace
{

constexpr std::size_t points = 4; /* of a cubic */

/* Of the polynomial through these rows. */
double value_at(double time_s, const std::array<std::size_t, points> &rows, const std::vector<double> &times_s,
                const std::vector<double> &values)
{
    double sum = 0.0;
    for (const std::size_t i : rows) {
        double weight = 1.0;
        for (const std::size_t j : rows) {
            weight *= i == j ? 1.0 : (time_s - times_s[j]) / (times_s[i] - times_s[j]);
        }
        sum += weight * values[i];
    }
    return sum;
}

/* How far each value is from the cubic through its neighbours, two on either side. */
double usual_distance(const std::vector<double> &times_s, const std::vector<double> &values)
{
    std::vector<double> off;
    for (std::size_t n = 2; n + 2 < values.size(); n++) {
        off.push_back(std::abs(values[n] - value_at(times_s[n], {n - 2, n - 1, n + 1, n + 2}, times_s, values)));
    }
    const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
    std::nth_element(off.begin(), middle, off.end());
    return *middle;
}

} // namespace

bool are_taken_at_stamps(const std::vector<double> &stamp_s, const std::vector<double> &due_s,
                         const std::vector<double> &smooth)
{
    constexpr std::size_t rows_min = 50;
    constexpr double far_better = 0.5; /* a choice: where noise hides the difference, both are alike */
    return smooth.size() >= rows_min && usual_distance(stamp_s, smooth) < far_better * usual_distance(due_s, smooth);
}

std::vector<double> at_due_times(const std::vector<double> &stamp_s, const std::vector<double> &due_s,
                                 const std::vector<double> &values)
{
    if (values.size() < points) {
        return values;
    }
    std::vector<double> made;
    for (const double due : due_s) {
        const auto after = std::upper_bound(stamp_s.begin(), stamp_s.end(), due) - stamp_s.begin();
        const auto last = static_cast<std::ptrdiff_t>(values.size() - points);
        const auto first = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(after - 2, 0, last));
        made.push_back(value_at(due, {first, first + 1, first + 2, first + 3}, stamp_s, values));
    }
    return made;
}

} // namespace berth
