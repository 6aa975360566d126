/* The measurement noise of a channel: what no model explains. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_NOISE_H
#define SIM_HAL_DIAGNOSIS_NOISE_NOISE_H

#include <cstdint>
#include <vector>

#include "../record/record.h"

namespace berth
{

/* What a row serves for. */
enum class row_use : std::uint8_t { none, fit, held_out };

/* e_n = a_1 e_(n-1) + ... + a_p e_(n-p) + w_n, w white with standard deviation sigma. Or, where that is the better
 * description, white noise and a slow one of first order, whose best prediction from the past is s:
 * e_n = s_n + w_n, s_(n+1) = decay (s_n + gain w_n). */
struct noise_model {
    std::vector<double> ar;
    double sigma = 1.0;
    double rms = 1.0;           /* of e */
    double rows_per_fact = 1.0; /* neighbouring rows that say the same; sigma is that much larger (square root) */
    std::size_t rows = 0;       /* that it was estimated from */
    double slow_decay = 0.0;
    double slow_gain = 0.0;

    bool has_colour() const { return !ar.empty() || slow_gain > 0.0; }
};

/* Makes signals white that are measured beside this noise, row by row. Rows out of use are unknown; after them, the
 * slow noise is predicted as far as it can be (a Kalman filter of one state). */
class whitening
{
  public:
    whitening(const noise_model &noise, const std::vector<row_use> &uses);

    /* Rows without a past in use have no white value of their own. */
    bool is_known(std::size_t row) const { return is_known_[row] != 0; }
    /* In standard deviations of w, as many as x has; 0 where it is not known. */
    void apply(const std::vector<double> &x, double *white) const;

  private:
    const noise_model &noise_;
    std::vector<std::uint8_t> is_known_;
    std::vector<double> gain_;  /* of the slow noise's prediction, one a row; empty: there is none */
    std::vector<double> scale_; /* one over the standard deviation of what is new */
};

/* What noise may be: a slow one needs rows that follow each other, not windows that start anew. */
enum class colour { regression, regression_or_slow };

/* By least squares over the rows in use. `order_max` lags are tried and as many kept as BIC wants. */
noise_model estimate_noise(const std::vector<double> &error, const std::vector<row_use> &uses, int order_max = 8,
                           colour colour = colour::regression_or_slow);

/* The same, blind to stretches that lie far outside of what is usual. */
noise_model estimate_noise_robustly(const std::vector<double> &error, const std::vector<row_use> &uses,
                                    colour colour);

/* White noise as large as third differences say, which hardly know of motion: their variance is 20 times its own. By
 * the median of their sizes, so that steps do not count. */
noise_model noise_of_differences(const std::vector<double> &error, const std::vector<row_use> &uses);

double median_of(std::vector<double> values);

/* w_n / sigma of the rows with this use, in order; rows whose past is not in use are left out. */
void whiten(const noise_model &noise, const std::vector<double> &error, const std::vector<row_use> &uses,
            row_use use, std::vector<double> &white);

/* Half width of the 95 % interval of the noise's rms, estimated from noise.rows, or from those in use for a fit: the
 * variance of a sample variance, 2 sigma^4 / N times the sum of the squared autocorrelation (Priestley, Spectral
 * Analysis and Time Series, 1981, 5.3). */
double rms_ci95(const noise_model &noise, const std::vector<row_use> &uses);

/* The same noise, but no smaller than `rms`. */
noise_model at_least(const noise_model &noise, double rms);

double sum_of_squares(const std::vector<double> &values);

/* How many rows in use show the same reading without a break, on average of these rows. */
double rows_of_a_reading(const std::vector<double> &values, const std::vector<row_use> &uses);

/* How far noise and rounding move a signal, rms: by its third differences, and no less than its steps do. */
double rms_of_noise_and_rounding(const std::vector<double> &signal);

/* rms over the rows with this use. */
double rms_of(const std::vector<double> &error, const std::vector<row_use> &uses, row_use use);

} // namespace berth

#endif
