/* What a signal was at rows that a logger lost, a few in a row. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_MISSING_VALUES_H
#define SIM_HAL_DIAGNOSIS_RECORD_MISSING_VALUES_H

#include <cstddef>
#include <vector>

#include "record.h"

namespace berth
{

/* Polynomials through as many rows before as behind. How many suits the signal and the number of missing rows: what
 * is smooth is told best by four on each side, what steps by one, and noise lies between. It is found by telling
 * rows that are there from those about them. */
class missing_values
{
  public:
    /* `place`: of each row among evenly spaced ones. Both outlive this. */
    missing_values(const std::vector<double> &signal, const std::vector<double> &place);

    /* `row` rows, from 1 on, behind row `before - 1`, with `count` missing ahead of row `before` of the same part.
     */
    double at(std::size_t before, std::size_t count, std::size_t row, const record_segment &part);

    /* Largest rms by which it was off where it was tried, of all numbers of missing rows that were asked for. */
    double error_rms() const { return error_rms_; }

  private:
    static constexpr std::size_t sides_max = 4;

    std::size_t rows_on_each_side(std::size_t count);
    double polynomial_at(std::size_t first, std::size_t before, std::size_t behind, std::size_t end,
                         double at) const;

    const std::vector<double> &signal_;
    const std::vector<double> &place_;
    std::vector<std::size_t> chosen_; /* for each number of missing rows; 0: not yet */
    double error_rms_ = 0.0;
};

} // namespace berth

#endif
