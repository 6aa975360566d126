#include "generator.h"

namespace berth
{

template <typename state_type>
Eigen::MatrixXd make_generator(const plant &original, contact_mode mode)
{
    plant linear = original; /* within a mode the contact force is affine */
    linear.one_sided = false;
    linear.surface_m = original.surface_m;
    if (mode == contact_mode::free) {
        linear.stiffness_N_per_m = 0.0;
        linear.damping_N_s_per_m = 0.0;
    }
    constexpr int states = state_type::RowsAtCompileTime;
    const state_type zero = state_type::Zero();
    const state_type constant = linear.derivative<state_type>(zero, {});
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(states + plant_input_count, states + plant_input_count);
    for (int i = 0; i < states; i++) {
        a.block<states, 1>(0, i) = linear.derivative<state_type>(state_type::Unit(i), {}) - constant;
    }
    a.block<states, 1>(0, states) = linear.derivative<state_type>(zero, {1.0, 0.0}) - constant;
    a.block<states, 1>(0, states + 1) = linear.derivative<state_type>(zero, {0.0, 1.0}) - constant;
    a.block<states, 1>(0, states + 2) = constant;
    a(states, states + 1) = 1.0; /* u grows by its slope */
    return a;
}

template Eigen::MatrixXd make_generator<plant_state>(const plant &, contact_mode);
template Eigen::MatrixXd make_generator<beam_state>(const plant &, contact_mode);

} // namespace berth
