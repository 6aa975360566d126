/* One interface for what advances the plant between two instants at which something discrete happens. Within an
 * interval the reference is one straight line; the caller splits time at setpoint arrivals and samples, so a
 * solver never meets a discontinuity that is known beforehand. */
#ifndef SIM_HAL_SOLVER_SOLVER_H
#define SIM_HAL_SOLVER_SOLVER_H

#include <cstdint>
#include <memory>

#include "../plant/plant.h"

namespace berth
{

class solver
{
  public:
    virtual ~solver() = default;

    /* Advances `state` by `duration_ns`; `line` is the reference, its position that at the start. */
    virtual void advance(beam_state &state, const reference_line &line, std::int64_t duration_ns) = 0;
};

/* Exact discretisation where the plant is linear. With contact: exact in each mode over fixed sub-steps, and a
 * sub-step in which the mode changes is halved down to the instant of the change. */
std::unique_ptr<solver> make_fast_solver(const rig &rig, const plant &plant);

/* SUNDIALS CVODE (Adams), stopped and started again at every known discontinuity. Throws input_error if the
 * program was built without SUNDIALS. */
std::unique_ptr<solver> make_cvode_solver(const rig &rig, const plant &plant);

/* The one that the rig asks for, of the equations `plant`. */
std::unique_ptr<solver> make_solver(const rig &rig, const plant &plant);

} // namespace berth

#endif
