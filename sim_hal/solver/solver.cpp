#include "solver.h"

#include "../../hal/rig/rig_file.h"

namespace berth
{

std::unique_ptr<solver> make_solver(const rig &rig)
{
    return rig.solver.kind == solver_kind::cvode ? make_cvode_solver(rig) : make_fast_solver(rig);
}

#ifndef BERTH_WITH_SUNDIALS
std::unique_ptr<solver> make_cvode_solver(const rig &)
{
    throw input_error("solver.kind: this program was built without SUNDIALS; use solver.kind = \"fast\"");
}
#endif

} // namespace berth
