#include "gain.h"

#include <algorithm>
#include <random>

namespace berth
{

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
    const auto half_second = static_cast<std::size_t>(0.5 / model.data().period_s);
    const auto length = std::max<std::size_t>(5, std::min(rows / 10, half_second));
    for (std::size_t begin = 0; begin + length <= rows; begin += length) {
        double before_sum = 0.0;
        double after_sum = 0.0;
        for (std::size_t n = begin; n < begin + length; n++) {
            before_sum += white_before[n] * white_before[n];
            after_sum += white_after[n] * white_after[n];
        }
        sums.before.push_back(before_sum);
        sums.after.push_back(after_sum);
    }
}

gain gain_from(const paired_sums &sums)
{
    if (sums.before.size() < 4) {
        return {0.0, -1.0, 1.0};
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
    gain result{gain_of(blocks), 0.0, 0.0};
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
