/* What a change of the rig does to the white error, less what the parameters that are free anyway make up for. */
#ifndef SIM_HAL_DIAGNOSIS_RESPONSE_H
#define SIM_HAL_DIAGNOSIS_RESPONSE_H

#include <Eigen/Core>

#include "fit.h"

namespace berth
{

/* White error of a rig over the rows of the fit. */
Eigen::VectorXd white_error(block_model &model, const noise_model &noise, const rig &rig);

/* The rig with an effect of these values switched on. */
rig with_values(const rig &base, const effect &effect, const effect_values &values);

/* What small changes of the parameters do to the white error; about `at`, whose white error is `white`. */
known_slopes slopes_at(block_model &model, const noise_model &noise, const fit_result &at,
                       const Eigen::VectorXd &white);

/* What the parameters can make up for, as an orthonormal basis; one at a bound cannot make up for anything more. */
class tangent_space
{
  public:
    tangent_space(const fit_result &at, const known_slopes &slopes);
    tangent_space(block_model &model, const noise_model &noise, const fit_result &at, const Eigen::VectorXd &white)
        : tangent_space(at, slopes_at(model, noise, at, white))
    {
    }

    Eigen::VectorXd less(const Eigen::VectorXd &x) const { return x - basis_ * (basis_.transpose() * x); }

  private:
    Eigen::MatrixXd basis_;
};

} // namespace berth

#endif
