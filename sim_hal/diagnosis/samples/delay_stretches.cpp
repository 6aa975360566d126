#include "delay_stretches.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

/* So many of a record, but none so short that it says nothing. */
constexpr std::size_t stretches_max = 60;
constexpr std::size_t rows_min = 40;

/* What a robot that is late by a period lacks, from tick to tick. */
std::vector<double> way_of_a_tick(const block_model &robot)
{
    const std::vector<double> &at_m = robot.motion().at_tick_m;
    std::vector<double> way_m(at_m.size(), 0.0);
    for (const record_segment &part : robot.data().segments) {
        for (std::size_t n = part.begin + 1; n + 1 < part.end; n++) {
            way_m[n] = 0.5 * (at_m[n + 1] - at_m[n - 1]);
        }
    }
    return way_m;
}

} // namespace

bool delay_stretches::are_clear() const
{
    constexpr double sure = 6.0; /* standard deviations of chi2 with so many degrees of freedom */
    return beyond_noise() > sure * std::sqrt(2.0 * count);
}

delay_stretches find_delay_stretches(const block_model &robot, const noise_model &noise,
                                     const std::vector<double> &error)
{
    const whitening by_row(noise, robot.uses());
    std::vector<double> way(error.size());
    std::vector<double> white(error.size());
    by_row.apply(way_of_a_tick(robot), way.data());
    by_row.apply(error, white.data());
    const std::size_t length = std::max(rows_min, error.size() / stretches_max);
    delay_stretches found;
    for (std::size_t begin = 0; begin < error.size(); begin += length) {
        double by_way = 0.0;
        double of_way = 0.0;
        for (std::size_t n = begin; n < std::min(error.size(), begin + length); n++) {
            by_way += way[n] * white[n];
            of_way += way[n] * way[n];
        }
        if (of_way > 0.0) {
            found.squares += by_way * by_way / of_way;
            found.count += 1.0;
        }
    }
    return found;
}

} // namespace berth
