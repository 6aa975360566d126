/* Parameters of a rig fitted to the error of a block: output error, weighted by the noise. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_FIT_H
#define SIM_HAL_DIAGNOSIS_FIT_FIT_H

#include <Eigen/Core>
#include <vector>

#include "../replay/block_model.h"
#include "prior.h"

namespace berth
{

/* Finite differences move the white error by no more: rms, where 1 is the noise. */
constexpr double change_max_per_row = 0.3;

struct fit_result {
    berth::rig rig;
    std::vector<free_parameter> parameters;
    std::vector<double> ci95;         /* half width, in the parameters' units */
    std::vector<double> ci95_if_slow; /* the same if what is left goes on alike for a twelfth of the rows */
    Eigen::MatrixXd correlation;      /* of the parameters; empty where there are no intervals */
    double cost = 0.0;                /* sum of squares of the white error over the rows of the fit */
    std::size_t rows = 0;
    int replays = 0;
};

/* Changes of the white error with the values of parameters, at a rig near the one to fit. */
struct known_slopes {
    std::vector<const rig_key *> keys;
    Eigen::MatrixXd white; /* a row each for the rows of the fit, a column each for the keys */
};

/* By bounded least squares from the values in `start`. With the slopes of some parameters known, a first look: these
 * are not computed again, and there are no intervals. */
fit_result fit(block_model &model, const noise_model &noise, const rig &start,
               const std::vector<free_parameter> &parameters, int replays_max,
               const known_slopes *first_look = nullptr);

/* White error of a rig over the rows of the fit. */
double cost_of(block_model &model, const noise_model &noise, const rig &rig, row_use use = row_use::fit);

/* What a fit knows of its parameters, as a prior; `kept`: see known_together(). */
std::vector<free_parameter> as_known(const fit_result &fitted, const std::vector<bool> &kept);

/* Those of an effect, with bounds about a start. */
std::vector<free_parameter> effect_parameters(const effect &effect, const rig &start);

/* `more` replaces those of `first` that have the same key. */
std::vector<free_parameter> joined(std::vector<free_parameter> first, const std::vector<free_parameter> &more);

} // namespace berth

#endif
