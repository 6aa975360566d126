/* Sine and cosine out of additions and multiplications alone, so that they have the same bits on every machine;
 * those of a C library do not. */
#ifndef FIRMWARE_ARM_SINE_H
#define FIRMWARE_ARM_SINE_H

#ifdef __cplusplus
extern "C" {
#endif

struct sine_cosine {
    double sine;
    double cosine;
};

/* Within 1 ulp of the larger of the two (2.3e-16) up to 1e6 rad; less exact beyond, and not finite for what is not
 * finite. */
struct sine_cosine sine_and_cosine(double angle_rad);

#ifdef __cplusplus
}
#endif
#endif
