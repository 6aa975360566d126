/* What the firmware's inverse filter gains and what it costs, from its coefficients. */
#ifndef SIM_HAL_STABILITY_INVERSE_FILTER_RESPONSE_H
#define SIM_HAL_STABILITY_INVERSE_FILTER_RESPONSE_H

#include "../../hal/rig/rig.h"

namespace berth
{

/* Upper end of the band in which the paper's robot is to be an ideal transmitter. */
constexpr double corrected_band_Hz = 5.0;

struct inverse_filter_response {
    double amplitude_error_without; /* largest | |G_R| - 1 | up to 5 Hz */
    double amplitude_error_with;    /* largest | |H G_R| - 1 | up to 5 Hz */
    double phase_deg;               /* of H at 5 Hz; negative: lags */
    double noise_gain;              /* of white noise on the setpoints, rms out over rms in */
};

/* The rig must have a transfer behaviour; H is 1 where the filter is not enabled. */
inverse_filter_response respond(const rig &rig);

} // namespace berth

#endif
