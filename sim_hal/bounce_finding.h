/* What the bounces of a run come to. */
#ifndef SIM_HAL_BOUNCE_FINDING_H
#define SIM_HAL_BOUNCE_FINDING_H

#include <cstddef>
#include <optional>
#include <string>

#include "motion.h"

namespace berth
{

/* Of the bounces of a run in which the operator did next to no work; of all where there are none. */
struct bounce_finding {
    std::size_t count;
    double restitution; /* median */
    double restitution_lowest;
    double restitution_highest;
    double energy_J; /* that a bounce adds to the manipulator's motion: median */
    bool is_even;    /* the interval of the median holds 1, or the sensor's noise makes as large a difference */

    bool is_driven = false; /* the operator's work is in them: they do not tell what the loop does */

    bool gains() const { return restitution > 1.0 && !is_even && !is_driven; }
};

/* Nothing: there was none. */
std::optional<bounce_finding> bounces_of(const motion_evidence &motion, double manipulator_mass_kg);

/* A tool that comes back from the material again and again, or has left it for good. */
bool is_bouncing(const motion_evidence &motion);

/* How many, what they do with the energy, and whether the tool came back. */
std::string bounce_words(const bounce_finding &bounces, const motion_evidence &motion);

} // namespace berth

#endif
