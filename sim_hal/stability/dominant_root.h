/* The largest eigenvalue of the loop without the others: Newton's method on the characteristic equation, started
 * from a neighbour on a map, and a count of zeros that proves that none has been overlooked. */
#ifndef SIM_HAL_STABILITY_DOMINANT_ROOT_H
#define SIM_HAL_STABILITY_DOMINANT_ROOT_H

#include <array>
#include <complex>
#include <vector>

#include "loop_equation.h"

namespace berth
{

class dominant_root_finder
{
  public:
    /* Largest |z| of the loop. Neighbouring rigs in succession, in equal steps, are fast. */
    double spectral_radius(const loop_equation &equation);

    /* The eigenvalue that spectral_radius() found; of a pair, the one with positive imaginary part. */
    std::complex<double> dominant_eigenvalue() const { return std::conj(1.0 / followed_[0]); }

    /* The next rig is not in the row: what is known of the modes stays, but not where they go. */
    void restart() { before_count_ = 0; }

    /* How often roots had to be searched for: at the start, and where a mode that was not followed took over. */
    long searches() const { return searches_; }

  private:
    bool follow(const loop_equation &equation);
    bool follow_others(const loop_equation &equation);
    void keep(const std::vector<std::complex<double>> &roots);

    static constexpr int followed_max = 8;
    std::array<std::complex<double>, followed_max> followed_{}; /* w of the upper half plane, smallest |w| first */
    int followed_count_ = 0;
    std::array<std::complex<double>, 3> before_{}; /* followed_[0] one, two and three rigs ago */
    int before_count_ = 0;
    long searches_ = 0;
};

/* True if F has no zero with |w| < radius. */
bool has_no_zero_inside(const loop_equation &equation, double radius);

} // namespace berth

#endif
