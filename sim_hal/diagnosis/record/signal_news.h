/* What a signal has in each row that neither its own past nor that of what it answers to tells. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_SIGNAL_NEWS_H
#define SIM_HAL_DIAGNOSIS_RECORD_SIGNAL_NEWS_H

#include <cstddef>
#include <cstdint>
#include <vector>

namespace berth
{

/* A measured signal and what it answers to, row by row. Either may be empty. */
struct measured_signal {
    std::vector<double> values;
    std::vector<double> cause;
    std::vector<std::uint8_t> is_guessed; /* rows that were missing; empty: none */

    measured_signal backwards() const;
};

/* The news in each row, by its sign alone: steps and impacts that any repetition has again are few rows. */
struct signal_news {
    std::vector<double> signs; /* 0: none */
    std::vector<double> news;
    double noise_rms = 0.0; /* of the signal, were it white */
};

/* By least squares over the changes of the last rows. */
signal_news news_of(const measured_signal &signal);

/* Of row `row` against the one before it. */
double change(const std::vector<double> &x, std::size_t row);

} // namespace berth

#endif
