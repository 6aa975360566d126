/* The largest eigenvalue of the loop without the others: Newton's method on the characteristic equation, started
 * from a neighbour on a map, and a count of zeros that proves that none has been overlooked. */
#ifndef SIM_HAL_STABILITY_DOMINANT_ROOT_H
#define SIM_HAL_STABILITY_DOMINANT_ROOT_H

#include <array>

#include "loop_equation.h"

namespace berth
{

class dominant_root_finder
{
  public:
    /* Largest |z| of the loop. Neighbouring rigs in succession are fast. */
    double spectral_radius(const loop_equation &equation);

    /* How often all roots had to be computed: at the start, and where another mode took over. */
    long full_solutions() const { return full_solutions_; }

  private:
    bool follow(const loop_equation &equation);
    void solve_fully(const loop_equation &equation);

    static constexpr int followed_max = 3;
    std::array<std::complex<double>, followed_max> followed_{}; /* w of upper half plane, smallest |w| first */
    int followed_count_ = 0;
    long full_solutions_ = 0;
};

/* True if F has no zero with |w| < radius. */
bool has_no_zero_inside(const loop_equation &equation, double radius);

} // namespace berth

#endif
