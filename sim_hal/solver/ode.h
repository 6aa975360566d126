/* Any ordinary differential equation to tight tolerances, by SUNDIALS CVODE (Adams): the truth that fixed steps are
 * measured against. */
#ifndef SIM_HAL_SOLVER_ODE_H
#define SIM_HAL_SOLVER_ODE_H

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "../../hal/rig/rig_file.h"

namespace berth
{

struct ode {
    /* d(state)/dt at a time in s. */
    std::function<Eigen::VectorXd(double time_s, const Eigen::VectorXd &state)> rate;
    /* Where it passes through zero, advance() stops; empty: nowhere. */
    std::function<double(double time_s, const Eigen::VectorXd &state)> event;
    long steps_max = 10000000; /* of one advance() */
};

/* By advance(): more steps than that, or none small enough. */
class not_solved : public input_error
{
    using input_error::input_error;
};

class ode_solver
{
  public:
    /* `absolute_tolerances`: one for each state. Throws input_error if the program was built without SUNDIALS. */
    ode_solver(ode ode, double relative_tolerance, const Eigen::VectorXd &absolute_tolerances);
    ~ode_solver();
    ode_solver(const ode_solver &) = delete;
    ode_solver &operator=(const ode_solver &) = delete;

    /* From `from_s` to `to_s`, started afresh: what acts may have jumped. Returns the time reached: that of an
     * event, or `to_s`. Throws not_solved. On the way it tells the states at the times in `outputs_s` that it
     * passes: ascending, after `from_s`. */
    double advance(Eigen::VectorXd &state, double from_s, double to_s, const std::vector<double> &outputs_s = {},
                   const std::function<void(double time_s, const Eigen::VectorXd &state)> &tell = {});

  private:
    struct parts;
    std::unique_ptr<parts> parts_;
};

} // namespace berth

#endif
