/* The measurement noise of a channel: what no model explains. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_H
#define SIM_HAL_DIAGNOSIS_NOISE_H

#include <cstdint>
#include <vector>

#include "record.h"

namespace berth
{

/* What a row serves for. */
enum class row_use : std::uint8_t { none, fit, held_out };

/* e_n = a_1 e_(n-1) + ... + a_p e_(n-p) + w_n, w white with standard deviation sigma. */
struct noise_model {
    std::vector<double> ar;
    double sigma = 1.0;
    double rms = 1.0;           /* of e */
    double rows_per_fact = 1.0; /* neighbouring rows that say the same; sigma is that much larger (square root) */
    std::size_t rows = 0;       /* that it was estimated from */
};

/* By least squares over the rows in use. `order_max` lags are tried and as many kept as BIC wants. */
noise_model estimate_noise(const std::vector<double> &error, const std::vector<row_use> &uses, int order_max = 8);

/* The same, blind to stretches that lie far outside of what is usual. */
noise_model estimate_noise_robustly(const std::vector<double> &error, const std::vector<row_use> &uses);

double median_of(std::vector<double> values);

/* w_n / sigma of the rows with this use, in order; rows whose past is not in use are left out. */
void whiten(const noise_model &noise, const std::vector<double> &error, const std::vector<row_use> &uses,
            row_use use, std::vector<double> &white);

/* The same noise, but no smaller than `rms`. */
noise_model at_least(const noise_model &noise, double rms);

double sum_of_squares(const std::vector<double> &values);

/* The step that all values are whole numbers of; 0: there is none. */
double lattice_step(const std::vector<double> &values);

/* rms over the rows with this use. */
double rms_of(const std::vector<double> &error, const std::vector<row_use> &uses, row_use use);

} // namespace berth

#endif
