#include "chain.h"

#include "../pi.h"
#include "factors.h"

namespace berth
{

namespace
{

template <class Space>
typename Space::vector vector_of(const double values[3])
{
    return Eigen::Map<const Eigen::Vector3d>(values).head<Space::dimension>();
}

template <class Space>
placement_of<Space> placement(const arm_frame &frame)
{
    const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(frame.axes);
    return {vector_of<Space>(frame.origin_m), axes.topLeftCorner<Space::dimension, Space::dimension>()};
}

template <class Space>
inertia_of<Space> inertia(const arm_body &body)
{
    const double *i = body.inertia_kg_m2;
    Eigen::Matrix<double, Space::turns, Space::turns> about_centre;
    if constexpr (Space::turns == 1) {
        about_centre << i[5];
    } else {
        about_centre << i[0], i[1], i[2], i[1], i[3], i[4], i[2], i[4], i[5];
    }
    return inertia_of<Space>::rigid(body.mass_kg, vector_of<Space>(body.centre_m), about_centre);
}

template <class Space>
chain_joint<Space> make_joint(const arm_joint &joint)
{
    const double motor = joint.rotor_inertia_kg_m2 * joint.gear_ratio * joint.gear_ratio;
    const double w = two_pi * joint.servo_frequency_Hz;
    return {placement<Space>(joint.frame),
            {Space::along_axis(Eigen::Map<const Eigen::Vector3d>(joint.axis)), Space::vector::Zero()},
            inertia<Space>(joint.link),
            joint.stiffness_N_m_per_rad,
            joint.damping_N_m_s_per_rad,
            motor,
            motor * w * w,
            2.0 * joint.servo_damping_ratio * w * motor,
            joint.torque_limit_N_m};
}

/* By outward sums, as if every joint stood at 0: that a body beyond a joint has inertia about it hardly depends on
 * where the joints behind it stand, and a link with an inertia of its own settles it. */
template <class Space>
arm_error check_inertia(const arm_config &config)
{
    const chain<Space> made = make_chain<Space>(config);
    inertia_of<Space> beyond = inertia_of<Space>::zero();
    for (int i = made.joint_count - 1; i >= 0; i--) {
        beyond += made.joints[i].link;
        if (!(dot(made.joints[i].axis, beyond * made.joints[i].axis) > 0.0)) {
            return {"joint.link", i, "inertia_kg_m2", "what the joint turns has no inertia about its axis"};
        }
        beyond = made.joints[i].placement.to_parent(beyond);
    }
    beyond += made.base;
    if (made.base_is_free && !is_positive_definite<motion_of<Space>::size>(beyond.matrix())) {
        return {"base", 0, "mass_kg", "a free base needs mass and inertia"};
    }
    return {nullptr, 0, nullptr, nullptr};
}

} // namespace

template <class Space>
chain<Space> make_chain(const arm_config &config)
{
    chain<Space> made;
    made.joint_count = static_cast<int>(config.joint_count);
    made.base_is_free = config.base_is_free != 0;
    made.base = inertia<Space>(config.base);
    for (int i = 0; i < made.joint_count; i++) {
        made.joints[i] = make_joint<Space>(config.joints[i]);
    }
    made.tool = placement<Space>(config.tool);
    inertia_of<Space> &last = made.joint_count > 0 ? made.joints[made.joint_count - 1].link : made.base;
    last += made.tool.to_parent(inertia<Space>(config.payload));
    made.gravity_m_per_s2 = vector_of<Space>(config.gravity_m_per_s2);
    return made;
}

template <class Space>
chain_state<Space> state_at_start(const arm_config &config)
{
    chain_state<Space> state;
    state.position_m() = vector_of<Space>(config.base_position_m);
    state.attitude() = Eigen::Map<const typename Space::attitude>(config.base_attitude);
    for (int i = 0; i < config.joint_count; i++) {
        state.link_rad()(i) = config.joints[i].initial_rad;
        state.motor_rad()(i) = config.joints[i].initial_rad;
    }
    return state;
}

template chain<plane> make_chain<plane>(const arm_config &);
template chain<space> make_chain<space>(const arm_config &);
template chain_state<plane> state_at_start<plane>(const arm_config &);
template chain_state<space> state_at_start<space>(const arm_config &);

} // namespace berth

arm_error arm_check_inertia(const arm_config *config)
{
    return config->kind == ARM_PLANAR ? berth::check_inertia<berth::plane>(*config)
                                      : berth::check_inertia<berth::space>(*config);
}
