#include "gain.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace berth
{

namespace
{

constexpr std::size_t parts_of_block = 5;

paired_sums merged(const paired_sums &parts)
{
    paired_sums blocks;
    for (std::size_t i = 0; i < parts.before.size(); i++) {
        if (i % parts_of_block == 0) {
            blocks.before.push_back(0.0);
            blocks.after.push_back(0.0);
        }
        blocks.before.back() += parts.before[i];
        blocks.after.back() += parts.after[i];
    }
    return blocks;
}

} // namespace

void add_sums(paired_sums &sums, block_model &model, const noise_model &noise, const rig &before, const rig &after,
              row_use use)
{
    std::vector<double> error;
    std::vector<double> white_before;
    std::vector<double> white_after;
    model.error(before, error);
    whiten(noise, error, model.uses(), use, white_before);
    model.error(after, error);
    whiten(noise, error, model.uses(), use, white_after);
    const std::size_t rows = white_before.size();
    const auto longest = static_cast<std::size_t>(0.5 / parts_of_block / model.data().period_s);
    const auto length = std::max<std::size_t>(5, std::min(rows / 10, longest));
    for (std::size_t begin = 0; begin + length <= rows; begin += length) {
        double before_sum = 0.0;
        double after_sum = 0.0;
        for (std::size_t n = begin; n < begin + length; n++) {
            before_sum += white_before[n] * white_before[n];
            after_sum += white_after[n] * white_after[n];
        }
        sums.before.push_back(before_sum);
        sums.after.push_back(after_sum);
        sums.rows += static_cast<double>(length) / noise.rows_per_fact;
    }
}

double blocks_that_differ(const paired_sums &parts)
{
    const paired_sums sums = merged(parts);
    double sum = 0.0;
    double square = 0.0;
    for (std::size_t i = 0; i < sums.before.size(); i++) {
        const double difference = std::abs(sums.before[i] - sums.after[i]);
        sum += difference;
        square += difference * difference;
    }
    return square > 0.0 ? sum * sum / square : 0.0;
}

gain gain_from(const paired_sums &parts)
{
    const paired_sums blocks_of_parts = merged(parts);
    /* What acts in one moment only is resampled in finer blocks: else every third draw misses it. */
    const paired_sums &sums =
        blocks_of_parts.before.size() < 4 || blocks_that_differ(parts) < few_blocks ? parts : blocks_of_parts;
    if (sums.before.size() < 4) {
        return {0.0, -1.0, 1.0, 0.0};
    }
    const auto gain_of = [&](const std::vector<std::size_t> &blocks) {
        double b = 0.0;
        double a = 0.0;
        for (const std::size_t i : blocks) {
            b += sums.before[i];
            a += sums.after[i];
        }
        return b > 0.0 ? 1.0 - a / b : 0.0;
    };
    std::vector<std::size_t> blocks(sums.before.size());
    for (std::size_t i = 0; i < blocks.size(); i++) {
        blocks[i] = i;
    }
    const double before = std::accumulate(sums.before.begin(), sums.before.end(), 0.0);
    const double after = std::accumulate(sums.after.begin(), sums.after.end(), 0.0);
    gain result{gain_of(blocks), 0.0, 0.0, (before - after) / std::max(1e-9, before - parts.rows)};
    std::mt19937 engine(1); /* the same record gives the same verdict */
    std::uniform_int_distribution<std::size_t> any(0, blocks.size() - 1);
    std::vector<double> gains;
    for (int trial = 0; trial < 400; trial++) {
        for (std::size_t &i : blocks) {
            i = any(engine);
        }
        gains.push_back(gain_of(blocks));
    }
    std::sort(gains.begin(), gains.end());
    result.low = gains[10];
    result.high = gains[389];
    return result;
}

} // namespace berth
