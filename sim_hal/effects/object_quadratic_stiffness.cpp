#include <cmath>

#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

effect object_quadratic_stiffness()
{
    effect made;
    made.name = "object.quadratic_stiffness";
    made.physics = "A spring that is stiffer on one side, even: a further force k2 x^2.";
    made.source = "Duffing";
    made.calibration = {26,
                        "pull the object slowly over its whole way, both ways, and record its force over the way"};
    made.parameters = {{"object.quadratic_stiffness_N_per_m2", -1e15, 1e15, "k2 of a further force k2 x^2"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return both_signs({0.03 * scales.force_N / std::pow(scales.position_m, 2),
                           0.3 * scales.force_N / std::pow(scales.position_m, 2)});
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<quadratic_spring>(value_of(rig, "object.quadratic_stiffness_N_per_m2"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::higher_order;
    return made;
}

} // namespace berth
