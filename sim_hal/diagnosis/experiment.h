/* What an operator could do to a rig, and what a simulated rig would measure. */
#ifndef SIM_HAL_DIAGNOSIS_EXPERIMENT_H
#define SIM_HAL_DIAGNOSIS_EXPERIMENT_H

#include <optional>
#include <string>
#include <vector>

#include "record/record.h"

namespace berth
{

struct excitation {
    profile_rig profile; /* amplitude_m or amplitude_N, as the rig's operator commands */
    double duration_s;
};

/* Kind, band and size, for people. */
std::string words_of(const excitation &excitation, const rig &rig);

std::string_view kind_of(const excitation &excitation);

/* Bands, sweeps, slow strokes, steps, pulses and standstill, about as large as what the record shows and a few times
 * larger. */
std::vector<excitation> candidate_excitations(const rig &rig, const record &shown);

/* The record of a run without noise and losses. Nothing: something stopped or limited the run, or it went farther
 * than `excursion_max_m` from where it started. */
std::optional<record> simulate_experiment(const rig &hypothesis, const excitation &excitation,
                                          double excursion_max_m);

/* Columns t_s and the operator's position or force, for `berth run --profile`. */
std::string profile_csv(const rig &rig, const excitation &excitation);

} // namespace berth

#endif
