#include "fourier.h"

#include <unsupported/Eigen/FFT>

namespace berth
{

std::vector<std::complex<double>> spectrum_of(const std::vector<double> &values)
{
    Eigen::FFT<double> fft;
    std::vector<std::complex<double>> lines;
    fft.fwd(lines, values);
    return lines;
}

std::vector<double> values_of(const std::vector<std::complex<double>> &spectrum)
{
    Eigen::FFT<double> fft;
    std::vector<double> values;
    fft.inv(values, spectrum, static_cast<Eigen::Index>(spectrum.size()));
    return values;
}

} // namespace berth
