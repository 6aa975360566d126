#include "sine.h"

#include <stdint.h>

/* pi/2 in three parts of 33 bits: their products with a quarter count of up to 2^20 are exact (Cody and Waite). */
static const double half_pi_parts[] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2e0p-69};
static const double quarters_per_rad = 0x1.45f306dc9c883p-1;

/* Added and taken away again, it leaves the nearest whole number. */
static const double rounder = 0x1.8p+52;

/* sin r / r and cos r as polynomials in r^2, Taylor's: for |r| <= pi/4 what is left out is below 1e-19. */
static const double sine_terms[] = {-1.0 / 6.0,          1.0 / 120.0,         -1.0 / 5040.0,
                                    1.0 / 362880.0,      -1.0 / 39916800.0,   1.0 / 6227020800.0,
                                    -1.0 / 1307674368e3, 1.0 / 355687428096e3};
static const double cosine_terms[] = {1.0 / 24.0,          -1.0 / 720.0,          1.0 / 40320.0,
                                      -1.0 / 3628800.0,    1.0 / 479001600.0,     -1.0 / 87178291200.0,
                                      1.0 / 20922789888e3, -1.0 / 6402373705728e3};

static double polynomial(const double terms[8], double x)
{
    double sum = terms[7];
    for (int i = 6; i >= 0; i--) {
        sum = sum * x + terms[i];
    }
    return sum;
}

struct sine_cosine sine_and_cosine(double angle_rad)
{
    const double quarters = (angle_rad * quarters_per_rad + rounder) - rounder;
    const double rest =
        ((angle_rad - quarters * half_pi_parts[0]) - quarters * half_pi_parts[1]) - quarters * half_pi_parts[2];
    const double square = rest * rest;
    const double sine = rest + rest * square * polynomial(sine_terms, square);
    const double half = 0.5 * square;
    const double above = 1.0 - half;
    const double cosine = above + (((1.0 - above) - half) + square * square * polynomial(cosine_terms, square));
    /* 0 to 3, of any number that is not too large to have quarters. */
    const double whole_turns = (quarters * 0.25 + rounder) - rounder;
    const double quadrant = quarters - 4.0 * whole_turns; /* -2 to 2 */
    if (quadrant == 1.0) {
        return (struct sine_cosine){cosine, -sine};
    }
    if (quadrant == -1.0) {
        return (struct sine_cosine){-cosine, sine};
    }
    if (quadrant == 0.0) {
        return (struct sine_cosine){sine, cosine};
    }
    return (struct sine_cosine){-sine, -cosine};
}
