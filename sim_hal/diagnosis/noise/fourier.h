/* Discrete Fourier transforms of signals of any length, by Eigen's FFT, compiled once. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_FOURIER_H
#define SIM_HAL_DIAGNOSIS_NOISE_FOURIER_H

#include <complex>
#include <vector>

namespace berth
{

/* As many lines as values, at multiples of 1 / (size * period): sums, not means. */
std::vector<std::complex<double>> spectrum_of(const std::vector<double> &values);

/* The other way round: the real values that have this spectrum. Of its lines the first half is read. */
std::vector<double> values_of(const std::vector<std::complex<double>> &spectrum);

} // namespace berth

#endif
