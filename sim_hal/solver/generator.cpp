#include "generator.h"

namespace berth
{

plant_generator make_generator(const plant &original, contact_mode mode)
{
    plant linear = original; /* within a mode the contact force is affine */
    linear.one_sided = false;
    linear.surface_m = original.surface_m;
    if (mode == contact_mode::free) {
        linear.stiffness_N_per_m = 0.0;
        linear.damping_N_s_per_m = 0.0;
    }
    const plant_state zero = plant_state::Zero();
    const plant_state constant = linear.derivative(zero, {});
    plant_generator a = plant_generator::Zero();
    for (int i = 0; i < plant_state_count; i++) {
        a.block<plant_state_count, 1>(0, i) = linear.derivative(plant_state::Unit(i), {}) - constant;
    }
    a.block<plant_state_count, 1>(0, plant_state_count) = linear.derivative(zero, {1.0, 0.0}) - constant;
    a.block<plant_state_count, 1>(0, plant_state_count + 1) = linear.derivative(zero, {0.0, 1.0}) - constant;
    a.block<plant_state_count, 1>(0, plant_state_count + 2) = constant;
    a(plant_state_count, plant_state_count + 1) = 1.0; /* u grows by its slope */
    return a;
}

} // namespace berth
