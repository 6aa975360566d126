#include "solver.h"

#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"

namespace berth
{

std::unique_ptr<solver> make_solver(const rig &rig, const plant &plant)
{
    if (rig.solver.kind != solver_kind::cvode) {
        return make_fast_solver(rig, plant);
    }
    if (has_hardware_effects(rig)) {
        throw input_error("solver.kind: CVODE integrates the base model only, and the rig has " +
                          effect_names(rig, is_hardware_effect) + "; use solver.kind = \"fast\"");
    }
    return make_cvode_solver(rig, plant);
}

#ifndef BERTH_WITH_SUNDIALS
std::unique_ptr<solver> make_cvode_solver(const rig &, const plant &)
{
    throw input_error("solver.kind: this program was built without SUNDIALS; use solver.kind = \"fast\"");
}
#endif

} // namespace berth
