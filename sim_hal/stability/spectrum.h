/* Eigenvalues of the one-period map and what they mean. */
#ifndef SIM_HAL_STABILITY_SPECTRUM_H
#define SIM_HAL_STABILITY_SPECTRUM_H

#include <complex>
#include <string>
#include <vector>

#include "../../hal/rig/rig.h"

namespace berth
{

/* What an eigenvalue z does from period to period: z = exp(s T). */
struct mode {
    std::complex<double> z;
    double growth_per_s;  /* ln|z| / T: Re s */
    double frequency_Hz;  /* |arg z| / (2 pi T): Im s / 2 pi */
    double damping_ratio; /* -Re s / |s| */
};

mode mode_of(std::complex<double> z, double period_s);

/* What swings, in words. `rig` is linear. */
std::string mode_name(const mode &mode, const rig &rig);

struct spectrum {
    std::vector<mode> modes; /* by falling |z|; of a pair, the one with positive imaginary part first */
    double spectral_radius;
    double growth_per_s;
    bool is_stable; /* every |z| < 1 */
};

/* Without a spring on either body nothing holds the two: z = 1 is an eigenvalue by itself, whatever rounding makes
 * of it, and the loop is neither stable nor unstable. An arm's free motion is left out instead. */
bool drifts_freely(const rig &rig);

/* Throws input_error where all eigenvalues at once take minutes, or the memory. */
void refuse_too_many_states(std::int64_t count);

/* Of the whole loop; with an arm: as arm_loop.h says. Throws input_error where the rig has no one-period map. */
spectrum loop_spectrum(const rig &rig);

/* Its largest |z|. */
double spectral_radius_of(const rig &rig);

/* A guess of it, for a search that asks a hundred times: of a map of many states by power iteration, in a
 * tenth of the time; of others the radius itself. What is found with it must be confirmed. */
double guessed_spectral_radius(const rig &rig);

/* Of the manipulator alone, and of manipulator and object rigidly coupled without dead time, sampled; with an arm:
 * of the arm. */
spectrum manipulator_spectrum(const rig &rig);
spectrum coupled_spectrum(const rig &rig);

/* Eigenfrequency ratio w/w_M and damping ratio of the coupled system without dead time: the axes of the maps.
 * w^2 = (K + k)/(M + m), zeta = (D + d)/(2 sqrt((K + k)(M + m))), w_M^2 = K/M. */
struct map_point {
    double frequency_ratio;
    double damping_ratio;
};

map_point map_point_of(const rig &rig);

} // namespace berth

#endif
