/* The strongest lines in an error, over time and over position. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_SPECTRUM_LINES_H
#define SIM_HAL_DIAGNOSIS_NOISE_SPECTRUM_LINES_H

#include <vector>

#include "noise.h"

namespace berth
{

/* Frequency of the strongest line, Hz; 0: none. */
double strongest_frequency_Hz(const std::vector<double> &error, double period_s);

/* Its frequency, in periods a row, where a line stands out of the noise about it, whatever its colour; else 0. */
double standing_line_periods(const std::vector<double> &error);

/* A line that stands out of the noise about it, whatever its colour. */
bool has_line(const std::vector<double> &error);

/* Takes out the strongest lines that stand out so, at most three: an error that repeats is no noise. */
void remove_lines(std::vector<double> &error, const std::vector<row_use> &uses);

/* Lengths over which the error repeats most, m; at most `count`. */
std::vector<double> strongest_pitches_m(const std::vector<double> &error, const std::vector<double> &position_m,
                                        int count);

} // namespace berth

#endif
