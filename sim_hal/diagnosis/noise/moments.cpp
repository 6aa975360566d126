#include "moments.h"

#include <algorithm>
#include <cmath>

#include "noise.h"

namespace berth
{

namespace
{

/* Sums of squares of neighbouring rows. */
std::vector<double> sums_of(const std::vector<double> &white, std::size_t length)
{
    std::vector<double> sums;
    sums.reserve(white.size() / length);
    for (std::size_t begin = 0; begin + length <= white.size(); begin += length) {
        double sum = 0.0;
        for (std::size_t n = begin; n < begin + length; n++) {
            sum += white[n] * white[n];
        }
        sums.push_back(sum);
    }
    return sums;
}

std::size_t rows_in(double duration_s, double period_s)
{
    return std::max<std::size_t>(10, static_cast<std::size_t>(duration_s / period_s));
}

} // namespace

double share_of_bad_moments(const std::vector<double> &white, double period_s)
{
    const std::size_t length = rows_in(0.5, period_s);
    const std::vector<double> sums = sums_of(white, length);
    const auto bad =
        std::count_if(sums.begin(), sums.end(), [&](double sum) { return sum > 1.6 * static_cast<double>(length); });
    return sums.empty() ? 0.0 : static_cast<double>(bad) / static_cast<double>(sums.size());
}

bool has_bursts(const std::vector<double> &white, double period_s)
{
    constexpr double beyond_noise = 8.0; /* standard deviations */
    constexpr double far_beyond = 50.0;
    const std::size_t length = rows_in(0.1, period_s);
    const std::vector<double> sums = sums_of(white, length);
    const double usual =
        std::max(median_of(sums), static_cast<double>(length)); /* of noise as large as it was taken for */
    const double spread = usual * std::sqrt(2.0 / static_cast<double>(length));
    const auto count_above = [&](double limit) {
        return std::count_if(sums.begin(), sums.end(), [&](double sum) { return sum > usual + limit * spread; });
    };
    return count_above(beyond_noise) >= 2 || count_above(far_beyond) >= 1;
}

} // namespace berth
