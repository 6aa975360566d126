#include "missing_values.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace berth
{

missing_values::missing_values(const std::vector<double> &signal, const std::vector<double> &place)
    : signal_(signal), place_(place)
{
}

/* Lagrange's, through rows `first` up to `before` and `behind` up to `end`, both exclusively. */
double missing_values::polynomial_at(std::size_t first, std::size_t before, std::size_t behind, std::size_t end,
                                     double at) const
{
    std::array<std::size_t, 2 * sides_max> rows{};
    std::size_t count = 0;
    for (std::size_t n = first; n < before; n++) {
        rows[count++] = n;
    }
    for (std::size_t n = behind; n < end; n++) {
        rows[count++] = n;
    }
    double sum = 0.0;
    for (std::size_t i = 0; i < count; i++) {
        double weight = 1.0;
        for (std::size_t j = 0; j < count; j++) {
            weight *= i == j ? 1.0 : (at - place_[rows[j]]) / (place_[rows[i]] - place_[rows[j]]);
        }
        sum += weight * signal_[rows[i]];
    }
    return sum;
}

std::size_t missing_values::rows_on_each_side(std::size_t count)
{
    constexpr std::size_t places_max = 1000;
    constexpr std::size_t usual = 2;
    constexpr double clearly = 0.8; /* of the sum of squares: more rows carry more noise to where they err most */
    chosen_.resize(std::max(chosen_.size(), count + 1), 0);
    if (chosen_[count] != 0) {
        return chosen_[count];
    }
    const std::size_t span = 2 * sides_max + count;
    const std::size_t step = std::max<std::size_t>(1, signal_.size() / places_max);
    std::array<double, sides_max + 1> error2{};
    std::size_t tried = 0;
    for (std::size_t from = 0; from + span <= signal_.size(); from += step) {
        if (place_[from + span - 1] - place_[from] != static_cast<double>(span - 1)) {
            continue; /* rows are missing here */
        }
        tried++;
        const std::size_t before = from + sides_max;
        const std::size_t behind = before + count;
        const std::size_t middle = before + count / 2;
        for (std::size_t sides = 1; sides <= sides_max; sides++) {
            const double told = polynomial_at(before - sides, before, behind, behind + sides, place_[middle]);
            error2[sides] += std::pow(told - signal_[middle], 2);
        }
    }
    std::size_t best = 1;
    for (std::size_t sides = 2; sides <= sides_max; sides++) {
        best = error2[sides] < clearly * error2[best] ? sides : best;
    }
    if (tried > 0) {
        error_rms_ = std::max(error_rms_, std::sqrt(error2[best] / static_cast<double>(tried)));
    }
    return chosen_[count] = tried == 0 ? usual : best;
}

double missing_values::at(std::size_t before, std::size_t count, std::size_t row, const record_segment &part)
{
    const std::size_t sides = rows_on_each_side(count);
    const std::size_t first = before - std::min(sides, before - part.begin);
    const std::size_t end = before + std::min(sides, part.end - before);
    return polynomial_at(first, before, before, end, place_[before - 1] + static_cast<double>(row));
}

} // namespace berth
