/* A solar generator as what it is: an Euler-Bernoulli beam with a spring at its root, as a sum of modes at its tip.
 */
#ifndef HAL_RIG_CANTILEVER_H
#define HAL_RIG_CANTILEVER_H

#include <limits>
#include <vector>

namespace berth
{

struct cantilever {
    double length_m = 0.0;
    double mass_kg_per_m = 0.0;
    double bending_stiffness_N_m2 = 0.0;                               /* E I */
    double root_N_m_per_rad = std::numeric_limits<double>::infinity(); /* infinite: clamped */
    double damping_ratio = 0.0;                                        /* of every mode */

    bool operator==(const cantilever &other) const
    {
        return length_m == other.length_m && mass_kg_per_m == other.mass_kg_per_m &&
               bending_stiffness_N_m2 == other.bending_stiffness_N_m2 &&
               root_N_m_per_rad == other.root_N_m_per_rad && damping_ratio == other.damping_ratio;
    }
};

/* What a mode is at the tip: a mass on spring and damper. The tip's way is the sum of all modes' ways, each of which
 * feels the whole force. */
struct beam_mode {
    double wave_number; /* beta L: 1.8751, 4.6941, 7.8548 ... where the root is clamped */
    double frequency_Hz;
    double mass_kg;
    double damping_N_s_per_m;
    double stiffness_N_per_m;
};

constexpr int beam_modes_max = 8;

/* What a root must have against the beam, root L / (E I): a softer one is a hinge that digits do not tell from none.
 */
constexpr double softest_root = 1e-6;

/* The first `count`, 1 to beam_modes_max, from k (1 + cos b cosh b) + b (cos b sinh b - sin b cosh b) = 0 with
 * k = root L / (E I). Throws input_error for a beam that is none. */
std::vector<beam_mode> modes_of(const cantilever &beam, int count);

/* The beam with a first mode of this frequency and mass at the tip, clamped, that is `length_m` long. */
cantilever beam_for(double length_m, double frequency_Hz, double tip_mass_kg, double damping_ratio);

} // namespace berth

#endif
