/* The memory of the firmware's compensation as a part of the state of the one-period map. */
#ifndef SIM_HAL_STABILITY_COMPENSATION_STATES_H
#define SIM_HAL_STABILITY_COMPENSATION_STATES_H

#include <Eigen/Core>
#include <vector>

#include "../../firmware/compensation/compensation.h"
#include "../../hal/rig/rig.h"

namespace berth
{

/* Whether it has eigenvalues: no passivity controller, which depends on energies, no identified model, no inverse
 * that adapts. */
bool compensation_is_linear(const rig &rig);

/* Throws input_error if the rig has a passivity controller, which depends on energies, or an identified model. */
void check_compensation_is_linear(const rig &rig);

/* Where a loop with compensation cannot be looked at. Throws input_error if one is on. */
void refuse_compensation(const rig &rig);

class compensation_states
{
  public:
    /* `config` must have been checked and must stay. */
    explicit compensation_states(const app_config &config);

    Eigen::Index count() const { return static_cast<Eigen::Index>(places(started_).size()); }

    /* The units as they are in a state, positions counted from the object's place at rest. */
    compensation in_state(const Eigen::Ref<const Eigen::VectorXd> &state, const manipulator &manipulator) const;

    /* The state that units are in. */
    Eigen::VectorXd state_of(compensation units) const { return values_at(places(units)); }

  private:
    std::vector<double *> places(compensation &units) const;
    static Eigen::VectorXd values_at(const std::vector<double *> &places);

    mutable compensation started_;
};

} // namespace berth

#endif
