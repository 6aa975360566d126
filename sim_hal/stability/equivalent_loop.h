/* The loop at one size of its motion: every effect that depends on it is replaced by what it does to the first
 * harmonic, gain and dead time of a signal, spring and damper of a body (harmonic balance; Gelb and Vander Velde
 * 1968, ch. 3). What is left is a linear rig, with eigenvalues and maps as any other.
 *
 * That holds for the mode that swings with that amplitude; phases are exact at its frequency alone, which is found
 * together with it. */
#ifndef SIM_HAL_STABILITY_EQUIVALENT_LOOP_H
#define SIM_HAL_STABILITY_EQUIVALENT_LOOP_H

#include <complex>
#include <string>
#include <vector>

#include "../../hal/rig/rig.h"
#include "describing_function.h"
#include "dominant_root.h"

namespace berth
{

/* Names of the effects of the rig that depend on the size of the motion. One-sided contact does, too, but belongs to
 * the base model. */
std::vector<std::string> effects_of_size(const rig &rig);

/* The amplitude that is asked for if nobody says: that of the profile, or 10 mm. */
double usual_amplitude_m(const rig &rig);

/* What an effect does to a sine, as a part of the loop. */
struct equivalent_part {
    std::string what; /* names of effects */
    double gain;      /* of a signal; 1 for forces */
    double lag_deg;
    spring_and_damper force; /* of a body */
};

struct equivalent_loop {
    rig linear; /* without effects of size */
    std::complex<double> z;
    double growth_per_s; /* not a number: the effects have no equivalent at this amplitude */
    double frequency_Hz; /* at which the phases are exact; of a mode that does not swing, that of the loop without */
    std::vector<equivalent_part> parts;
    bool has_settled; /* frequency and amplitudes agree with each other */
};

/* Finds the mode that grows most where the manipulator swings by an amplitude. Neighbouring rigs in succession are
 * fast. */
class equivalent_finder
{
  public:
    explicit equivalent_finder(double amplitude_m) : amplitude_m_(amplitude_m) {}

    /* Throws input_error where there is no linear loop even so. */
    equivalent_loop find(const rig &rig);

    /* The next rig is not next to the last one. */
    void restart() { w_rad_per_s_ = 0.0; }

  private:
    enum class follows { largest, nearest };
    equivalent_loop settle(const rig &rig, double w_rad_per_s, follows mode);

    double amplitude_m_;
    double w_rad_per_s_ = 0.0; /* of the last one */
    dominant_root_finder roots_;
};

/* An equivalent takes a simulation of several periods, or many rounds: milliseconds, and more where a slow mode
 * swings on a stiff contact. */
bool is_slow_to_find(const rig &rig);

/* An amplitude at which the loop neither grows nor decays. */
struct limit_cycle {
    double amplitude_m;
    double frequency_Hz;
    bool attracts; /* smaller motion grows to it, larger one decays to it; else it parts them */
};

/* Within a factor of 30 of the amplitude, either way; by rising amplitude. */
std::vector<limit_cycle> limit_cycles(const rig &rig, double amplitude_m);

} // namespace berth

#endif
