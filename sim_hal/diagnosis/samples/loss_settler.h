/* Which setpoints were lost, by all that their losses do together. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_SETTLER_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_SETTLER_H

#include <algorithm>
#include <cstdint>
#include <vector>

#include "../replay/block_model.h"
#include "loss_trace.h"

namespace berth
{

/* Where one in four is lost, the most that is looked at, 400 a second, once in a year more are lost in a row: what
 * stands still for longer has another reason. */
constexpr int losses_in_a_row_max = 16;

/* Standard deviation of most of it. */
double sigma_of(const std::vector<double> &error, const std::vector<row_use> &uses);

/* Setpoints that the robot stands on in each row: of lost ones those before. */
std::vector<double> taken_of(const std::vector<double> &sent, const std::vector<std::uint8_t> &lost);

/* Numbers of which the largest is asked for again and again while few of them change. */
class largest_of
{
  public:
    explicit largest_of(std::size_t count) : values_(count, 0.0), of_block_(count / block + 1, 0.0) {}

    /* values(i) for each i in [from, to). */
    template <typename function>
    void renew(std::size_t from, std::size_t to, function values)
    {
        for (std::size_t i = from; i < to; i++) {
            values_[i] = values(i);
        }
        for (std::size_t b = from / block; b * block < to; b++) {
            const auto begin = values_.begin() + static_cast<std::ptrdiff_t>(b * block);
            const auto end =
                values_.begin() + static_cast<std::ptrdiff_t>(std::min(values_.size(), (b + 1) * block));
            of_block_[b] = *std::max_element(begin, end);
        }
    }

    /* Its place, the first one of several. */
    std::size_t place() const
    {
        const auto best = std::max_element(of_block_.begin(), of_block_.end());
        const auto begin = values_.begin() + (best - of_block_.begin()) * static_cast<std::ptrdiff_t>(block);
        return static_cast<std::size_t>(std::find(begin, values_.end(), *best) - values_.begin());
    }

    double operator[](std::size_t i) const { return values_[i]; }

  private:
    static constexpr std::size_t block = 256;
    std::vector<double> values_;
    std::vector<double> of_block_;
};

/* Losses next to each other are not the sum of losses: of the second one the robot lacks the first one's way, too.
 * So each setpoint is taken for lost, or for not lost after all, where the error is smaller for it, alone or with
 * one of its neighbours: a loss found one tick off is two mistakes. */
class loss_settler
{
  public:
    /* `error`: of a replay with the losses that were `known`. */
    loss_settler(const block_model &model, const loss_trace &loss, const std::vector<double> &error,
                 const std::vector<std::uint8_t> &known, std::vector<std::uint8_t> first_guess);

    /* `least`: squares of sigma that a loss has to explain. What helps most goes first: a loss that is missing makes
     * the force ring, and others in a row would take the ringing away bit by bit. */
    void settle(double least);

    /* Sum of squares that is left, of rows whose count is 1. */
    double square() const { return square(0, rest_.size()); }
    const std::vector<double> &rest() const { return rest_; }
    const std::vector<double> &counts() const { return counts_; }

    std::vector<std::uint8_t> lost;

  private:
    double square(std::size_t begin, std::size_t end) const;
    bool take_best_first(largest_of &helps, double least);

    /* Three losses within a few ticks may cancel each other so far that none of them, nor two, explains anything:
     * where an error begins that is far above all before it, every combination is tried. */
    bool search_bursts(double least);
    bool try_all(std::size_t from, double least);
    /* The bit in which the i-th number of Gray's code differs from the one before. */
    void flip_one_of(std::size_t from, unsigned i);

    /* By how much the sum of squares falls, beyond what a further loss has to explain, where a setpoint and one of
     * its neighbours are taken for the opposite of what they were. */
    void find_help(largest_of &helps, std::size_t from, std::size_t to, double least);
    double help_of(std::size_t first, std::size_t second, double least);

    /* Returns the end of the setpoints that it has an influence on; changed_ has what it does to the sum of squares.
     */
    std::size_t flip(std::size_t first, std::size_t second);
    /* Of losses one after the other, of which one is at `first` or later, up to `last`. */
    std::size_t longest_run(std::size_t first, std::size_t last) const;
    /* The robot stands on this setpoint in tick n; the error is then another one. */
    void put(std::size_t n, double taken);

    const block_model &model_;
    const loss_trace &loss_;
    const std::vector<double> &sent_;
    std::vector<double> rest_;
    std::vector<double> counts_; /* 1: the row is compared; 0 */
    std::vector<double> taken_;
    double changed_ = 0.0; /* of the sum of squares, by what was put since it was set to nought */
    std::size_t end_;
};

} // namespace berth

#endif
