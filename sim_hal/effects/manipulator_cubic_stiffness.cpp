#include <cmath>

#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

effect manipulator_cubic_stiffness()
{
    effect made;
    made.name = "manipulator.cubic_stiffness";
    made.physics = "A spring that hardens or softens, odd: a further force K3 (x - x_op)^3.";
    made.source = "Duffing";
    made.calibration = {32, "pull the manipulator slowly over its whole way, and record the force over the way"};
    made.parameters = {
        {"manipulator.cubic_stiffness_N_per_m3", -1e15, 1e15, "K3 of a further force K3 (x - x_op)^3"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return both_signs({0.03 * scales.force_N / std::pow(scales.position_m, 3),
                           0.3 * scales.force_N / std::pow(scales.position_m, 3)});
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<cubic_spring>(value_of(rig, "manipulator.cubic_stiffness_N_per_m3"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::higher_order;
    return made;
}

} // namespace berth
