/* Growth rate and frequency of an oscillation, measured from its tail by the logarithmic decrement. */
#ifndef SIM_HAL_STABILITY_GROWTH_FIT_H
#define SIM_HAL_STABILITY_GROWTH_FIT_H

#include <cstddef>
#include <optional>
#include <vector>

namespace berth
{

/* Distance between two successive extremes, halfway between them in time. */
struct oscillation_height {
    double time_s;
    double value;
};

struct growth_fit {
    double growth_per_s;      /* negative: decays */
    double growth_ci95_per_s; /* from the scatter of the heights; at least half of what the two halves differ by, and
                                 as far as the slope of any quarter */
    double frequency_Hz;
    double from_s; /* part of the signal that was used */
    double to_s;
    double height_from; /* of the fitted exponential at from_s */
    std::size_t extremes;
};

/* Heights of `signal`, sampled every `period_s`; a parabola through three samples gives each extreme. */
std::vector<oscillation_height> oscillation_heights(const std::vector<double> &signal, double period_s);

/* Heights between successive extremes are free of a constant offset; a straight line through their logarithms
 * over time gives the growth. Heights lower than `floor`, or than four times a level at which the signal has
 * settled without falling or rising evenly any more, are left out, and so is the first quarter of the rest, where
 * faster modes still show. Nothing: fewer than 8 extremes remain. */
std::optional<growth_fit> fit_growth(const std::vector<double> &signal, double period_s, double floor);

} // namespace berth

#endif
