/* From a first guess of the lost setpoints to all that the error shows. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_FINDER_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_FINDER_H

#include <algorithm>
#include <cstdint>
#include <vector>

#include "../replay/driven_path.h"
#include "events.h"
#include "loss_settler.h"

namespace berth
{

class loss_finder
{
  public:
    /* `error`: of a replay with the losses that were `known`; `tries`: setpoints whose loss would be clear. */
    loss_finder(const block_model &model, const rig &rig, const loss_trace &loss, const std::vector<double> &error,
                const std::vector<std::uint8_t> &known, std::size_t tries);

    /* Settles a guess, and decodes where that leaves much; needs a rig that follows its setpoints. */
    void settle(std::vector<std::uint8_t> guess, double left_max);

    /* Decides all, one after the other; takes what it finds if that is better, and not where any losses would leave
     * more than `left_max` of the squares. */
    void decode(double left_max);

    /* Decides the first ones. */
    void decode_first(std::size_t ticks);

    std::vector<std::uint8_t> lost;
    bool is_decoded = false;

    /* Of the squares that are there without any loss. */
    double share_left() const { return square_ / std::max(none_.square(), 1e-300); }
    double sigma_left() const { return sigma_; }

    /* Of what was decoded, and of others that leave this error: squares, and what each loss has to explain. */
    double cost() const { return square_ + penalty_ * static_cast<double>(count_of(lost)); }
    double cost_of(const std::vector<double> &rest, const std::vector<std::uint8_t> &rows) const;

    /* The same whatever the noise may be: rows times the logarithm of the squares, and that of the odds. */
    double information() const;

    /* Squares of sigma that a loss has to explain: where one in eight is lost, less than where one in a thousand is.
     */
    double least(const std::vector<std::uint8_t> &rows) const;

  private:
    void decode(std::size_t ticks, double left_max);
    double rows_compared() const;

    const block_model &model_;
    driven_path path_;
    const loss_trace &loss_;
    const std::vector<double> &error_;
    const std::vector<std::uint8_t> &known_;
    std::size_t tries_;
    loss_settler none_;
    double square_ = 0.0;
    double sigma_ = 0.0;
    double penalty_ = 0.0;
};

} // namespace berth

#endif
