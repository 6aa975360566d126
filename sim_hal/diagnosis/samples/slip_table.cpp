#include "slip_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace berth
{

slip_answers answers_to_slips(const rig &rig, const record &data, const slip_search &search)
{
    constexpr double share_max = 0.5; /* of the record, for all answers */
    constexpr double more = 6.0;      /* rows on either side */
    slip_answers made;
    made.times_s = slip_times_s(rig, data);
    const double answer = search.answer_s / data.period_s;
    const double rows_each = share_max * static_cast<double>(data.size()) / static_cast<double>(made.times_s.size());
    made.ticks_max = std::min(search.ticks_max, std::floor(0.5 * (rows_each - answer) - more));
    if (made.times_s.empty() || made.ticks_max < 2.0 * search.ticks_step) {
        return made;
    }
    const auto before = static_cast<std::size_t>(made.ticks_max + more);
    const auto after = before + static_cast<std::size_t>(answer);
    const double begin_s = data.time_s.front() - data.time_origin_s;
    for (const double time_s : made.times_s) {
        const auto slip = static_cast<std::size_t>((time_s - begin_s) / data.period_s);
        made.rows.push_back({slip - std::min(slip, before), std::min(data.size(), slip + after)});
    }
    return made;
}

slip_table::slip_table(block_model &model, const rig &rig, const slip_answers &slips, double ticks_step,
                       const clock_ways &ways)
    : reach_(static_cast<int>(slips.ticks_max / ticks_step)),
      step_ms_(ticks_step * 1e-3 * rig.robot.clock_drift_ppm * model.data().period_s), times_s_(slips.times_s),
      squares_(slips.rows.size())
{
    std::vector<double> error;
    for (int steps = -reach_; steps <= reach_; steps++) {
        berth::rig moved = rig;
        ways.shift(moved, steps * step_ms_);
        model.error(moved, error);
        for (std::size_t slip = 0; slip < squares_.size(); slip++) {
            const auto begin = error.begin() + static_cast<std::ptrdiff_t>(slips.rows[slip].begin);
            const auto end = error.begin() + static_cast<std::ptrdiff_t>(slips.rows[slip].end);
            squares_[slip].push_back(std::inner_product(begin, end, begin, 0.0));
        }
    }
}

bool slip_table::apply_best(rig &rig, const clock_ways &ways) const
{
    constexpr double near_end = 0.75; /* the answer of the right tick begins before it, and ends after it */
    line best{0, 0, sum_on(0, 0)};
    for_each_line([&](const line &one) { best = one.sum < best.sum ? one : best; });
    if (squares_.size() > 1) {
        ways.turn_about(rig, 1e3 * turn_ms_per_s(best), times_s_.front());
    }
    ways.shift(rig, best.first * step_ms_);
    return std::max(std::abs(best.first), std::abs(best.last)) >= near_end * reach_;
}

slip_table::width slip_table::within(double rise_max) const
{
    double least = unlimited;
    for_each_line([&](const line &one) { least = std::min(least, one.sum); });
    width made;
    for_each_line([&](const line &one) {
        if (one.sum < least + rise_max) {
            const double turn = squares_.size() > 1 ? turn_ms_per_s(one) : 0.0;
            const double phase_ms = one.first * step_ms_ - turn * times_s_.front();
            made.drift_ppm = std::max(made.drift_ppm, std::abs(1e3 * turn));
            made.phase_ms = std::max(made.phase_ms, std::abs(phase_ms));
        }
    });
    return made;
}

void slip_table::for_each_line(const std::function<void(const line &)> &visit) const
{
    const bool is_single = squares_.size() == 1;
    for (int first = -reach_; first <= reach_; first++) {
        for (int last = is_single ? first : -reach_; last <= (is_single ? first : reach_); last++) {
            visit({first, last, sum_on(first, last)});
        }
    }
}

double slip_table::turn_ms_per_s(const line &one) const
{
    return (one.last - one.first) * step_ms_ / (times_s_.back() - times_s_.front());
}

double slip_table::sum_on(int first, int last) const
{
    double sum = 0.0;
    const double length_s = times_s_.back() - times_s_.front();
    for (std::size_t slip = 0; slip < squares_.size(); slip++) {
        const double way = length_s != 0.0 ? (times_s_[slip] - times_s_.front()) / length_s : 0.0;
        const auto steps = std::lround(first + way * (last - first));
        sum += squares_[slip][static_cast<std::size_t>(steps + reach_)];
    }
    return sum;
}

} // namespace berth
