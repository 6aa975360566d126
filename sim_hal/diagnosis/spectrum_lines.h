/* The strongest lines in an error, over time and over position. */
#ifndef SIM_HAL_DIAGNOSIS_SPECTRUM_LINES_H
#define SIM_HAL_DIAGNOSIS_SPECTRUM_LINES_H

#include <vector>

namespace berth
{

/* Frequency of the strongest line, Hz; 0: none. */
double strongest_frequency_Hz(const std::vector<double> &error, double period_s);

/* A line that stands out of the noise about it, whatever its colour. */
bool has_line(const std::vector<double> &error);

/* Lengths over which the error repeats most, m; at most `count`. */
std::vector<double> strongest_pitches_m(const std::vector<double> &error, const std::vector<double> &position_m,
                                        int count);

} // namespace berth

#endif
