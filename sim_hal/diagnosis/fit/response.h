/* What a change of the rig does to the white error, less what the parameters that are free anyway make up for. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_RESPONSE_H
#define SIM_HAL_DIAGNOSIS_FIT_RESPONSE_H

#include <Eigen/Core>
#include <optional>
#include <vector>

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

/* What the parameters can make up for. One at a bound cannot make up for anything more, only for less. */
class tangent_space
{
  public:
    tangent_space(const fit_result &at, const known_slopes &slopes);
    tangent_space(block_model &model, const noise_model &noise, const fit_result &at, const Eigen::VectorXd &white)
        : tangent_space(at, slopes_at(model, noise, at, white))
    {
    }

    /* Without what the parameters that are not at a bound make up for. */
    Eigen::VectorXd less(const Eigen::VectorXd &x) const { return x - basis_ * (basis_.transpose() * x); }

    /* How much smaller the sum of squares of a white error gets with `share` times `change` added to it, the
     * parameters making the best of it; `share` is the best one between `least` and `most`. */
    struct prospect {
        double decrease;
        double share;
    };
    /* A white error, and what the parameters leave of it. */
    struct target {
        Eigen::VectorXd white;
        Eigen::VectorXd rest;
        Eigen::VectorXd rest_of_all; /* with those at a bound */
        double decrease_by_all;      /* what these could do without any change */
        Eigen::VectorXd along_all;   /* its scalar products with all slopes */
    };
    target target_of(const Eigen::VectorXd &white) const;
    /* `changed`: the effect whose change it is; where its parameters are some of these, they make up for nothing. */
    prospect best_share(const target &error, const Eigen::VectorXd &change, double least, double most,
                        const effect *changed = nullptr) const;

    /* Where the bounds of `at` hold some of an effect's own parameters: the values that the slopes ask for, were
     * there none, within the effect's own; else nothing. */
    std::optional<effect_values> beyond_bounds(const fit_result &at, const target &error, const effect &own) const;

    /* The least sum of squares that a share leaves, were no parameter at a bound. */
    double least_left(const target &error, const Eigen::VectorXd &change, double least, double most) const;

  private:
    /* With those of the parameters at a bound that would go inward, as far as they do. */
    prospect best_inward(const target &error, const Eigen::VectorXd &change, double least, double most,
                         std::vector<Eigen::Index> released) const;
    bool is_of(const effect *changed, Eigen::Index column) const;

    std::vector<const rig_key *> keys_;
    Eigen::MatrixXd products_of_all_; /* scalar products of the slopes with each other */
    Eigen::MatrixXd basis_;           /* orthonormal; of those not at a bound */
    Eigen::MatrixXd basis_of_all_;    /* the same with those at a bound; empty: there are none */
    Eigen::MatrixXd slopes_of_all_;   /* columns of size 1 */
    Eigen::VectorXd sizes_;           /* that they had */
    std::vector<double> inward_;      /* one a column: the sign in which it may go, 0: either */
};

} // namespace berth

#endif
