#include "dynamics.h"

#include <algorithm>

#include "factors.h"

namespace berth
{

namespace
{

template <class Space>
using square = Eigen::Matrix<double, motion_of<Space>::size, motion_of<Space>::size>;
template <class Space>
using column = Eigen::Matrix<double, motion_of<Space>::size, 1>;

template <class Space>
column<Space> stacked(const wrench_of<Space> &wrench)
{
    column<Space> all;
    all << wrench.torque, wrench.force;
    return all;
}

template <class Space>
column<Space> stacked(const motion_of<Space> &motion)
{
    column<Space> all;
    all << motion.angular, motion.linear;
    return all;
}

template <class Space>
motion_of<Space> motion_from(const column<Space> &all)
{
    return {all.template head<Space::turns>(), all.template tail<Space::dimension>()};
}

/* What each joint's elimination leaves behind. */
template <class Space>
struct joint_step {
    motion_of<Space> carried; /* acceleration that the joint's rate brings by itself */
    wrench_of<Space> shared;  /* of the articulated inertia along the axis */
    double inertia_kg_m2;
    double torque_N_m;
};

} // namespace

template <class Space>
chain_pose<Space> pose_of(const chain<Space> &chain, const joint_vector &link_rad)
{
    chain_pose<Space> pose;
    for (int i = 0; i < chain.joint_count; i++) {
        const chain_joint<Space> &joint = chain.joints[i];
        const sine_cosine turn = sine_and_cosine(link_rad(i));
        pose.links[i] = {joint.placement.origin_m,
                         joint.placement.axes * Space::turned(joint.axis.angular, turn.sine, turn.cosine)};
    }
    return pose;
}

template <class Space>
placement_of<Space> tool_in_base(const chain<Space> &chain, const chain_pose<Space> &pose)
{
    placement_of<Space> place = {Space::vector::Zero(), Space::rotation::Identity()};
    for (int i = 0; i < chain.joint_count; i++) {
        place = place * pose.links[i];
    }
    return place * chain.tool;
}

/* Flattened: as calls, its many small products cost more in handing over than in reckoning. */
template <class Space>
[[gnu::flatten]] chain_acceleration<Space>
forward_dynamics(const chain<Space> &chain, const chain_state<Space> &state, const joint_drive &drive,
                 const chain_input<Space> &input)
{
    const int count = chain.joint_count;
    const chain_pose<Space> pose = pose_of(chain, joint_vector(state.link_rad()));
    const motion_of<Space> twist = state.twist();
    const typename Space::rotation world_axes = Space::axes_of(state.attitude());

    inertia_of<Space> inertias[ARM_JOINTS_MAX + 1]; /* base first */
    wrench_of<Space> biases[ARM_JOINTS_MAX + 1];
    joint_step<Space> steps[ARM_JOINTS_MAX];

    const wrench_of<Space> base_momentum = chain.base * twist;
    const typename Space::angular wheel = state.wheel();
    inertias[0] = chain.base;
    biases[0] = cross(twist, base_momentum);
    biases[0].torque += Space::cross(twist.angular, wheel) - input.wheel_torque_N_m - input.thruster_torque_N_m;

    motion_of<Space> motion = twist;
    typename Space::rotation axes_in_base = Space::rotation::Identity();
    for (int i = 0; i < count; i++) {
        const motion_of<Space> turning = chain.joints[i].axis * state.link_rate()(i);
        motion = pose.links[i].to_child(motion) + turning;
        steps[i].carried = cross(motion, turning);
        inertias[i + 1] = chain.joints[i].link;
        biases[i + 1] = cross(motion, chain.joints[i].link * motion);
        axes_in_base = axes_in_base * pose.links[i].axes;
    }

    /* The wrench on the tool, into the axes of the last body, about its origin. */
    const placement_of<Space> world = {Space::vector::Zero(), world_axes * axes_in_base};
    const wrench_of<Space> on_tool = {world.turn_back(input.tool.torque), world.axes.transpose() * input.tool.force};
    const placement_of<Space> tool_origin = {chain.tool.origin_m, Space::rotation::Identity()};
    biases[count] = biases[count] - tool_origin.to_parent(on_tool);

    for (int i = count - 1; i >= 0; i--) {
        const motion_of<Space> &axis = chain.joints[i].axis;
        inertia_of<Space> &inertia = inertias[i + 1];
        joint_step<Space> &step = steps[i];
        step.shared = inertia * axis;
        step.inertia_kg_m2 = dot(axis, step.shared) + drive.armature_kg_m2(i);
        step.torque_N_m = drive.torque_N_m(i) - dot(axis, biases[i + 1]);
        inertia.remove(step.shared, step.inertia_kg_m2);
        const wrench_of<Space> bias =
            biases[i + 1] + inertia * step.carried + step.shared * (step.torque_N_m / step.inertia_kg_m2);
        inertias[i] += pose.links[i].to_parent(inertia);
        biases[i] = biases[i] + pose.links[i].to_parent(bias);
    }

    chain_acceleration<Space> result;
    result.link_rad_per_s2.setZero();
    const motion_of<Space> falling = {Space::angular::Zero(), world_axes.transpose() * chain.gravity_m_per_s2};
    motion_of<Space> acceleration = falling * -1.0;
    if (chain.base_is_free) {
        acceleration =
            motion_from<Space>(-positive_solution<motion_of<Space>::size>(inertias[0].matrix(), stacked(biases[0])));
    }
    result.base = chain.base_is_free ? acceleration + falling : motion_of<Space>::zero();
    for (int i = 0; i < count; i++) {
        const motion_of<Space> carried = pose.links[i].to_child(acceleration) + steps[i].carried;
        const double turning = (steps[i].torque_N_m - dot(carried, steps[i].shared)) / steps[i].inertia_kg_m2;
        result.link_rad_per_s2(i) = turning;
        acceleration = carried + chain.joints[i].axis * turning;
    }
    return result;
}

template <class Space>
elastic_joints drive_joints(const chain<Space> &chain, const chain_state<Space> &state,
                            const chain_input<Space> &input, double step_s, double offset_s,
                            const joint_vector &motor_rad_per_s2)
{
    const double half_s = 0.5 * step_s;
    elastic_joints result = {
        {joint_vector::Zero(), joint_vector::Zero()}, joint_vector::Zero(), joint_vector::Zero(), 0};
    for (int i = 0; i < chain.joint_count; i++) {
        const chain_joint<Space> &joint = chain.joints[i];
        const double motor_rate = state.motor_rate()(i);
        const double twist_rate = motor_rate - state.link_rate()(i);
        const double twist_rad = state.motor_rad()(i) - state.link_rad()(i) + half_s * twist_rate;
        const double command_rad = input.command_rad(i) + (offset_s + half_s) * input.command_rad_per_s(i);
        const double spring = joint.stiffness_N_m_per_rad * twist_rad + joint.damping_N_m_s_per_rad * twist_rate;
        const double yielding = half_s * (half_s * joint.stiffness_N_m_per_rad + joint.damping_N_m_s_per_rad);
        double servo =
            joint.servo_stiffness_N_m_per_rad * (command_rad - state.motor_rad()(i) - half_s * motor_rate) +
            joint.servo_damping_N_m_s_per_rad * (input.command_rad_per_s(i) - motor_rate);
        double giving = half_s * (half_s * joint.servo_stiffness_N_m_per_rad + joint.servo_damping_N_m_s_per_rad);
        const double expected = servo - giving * motor_rad_per_s2(i);
        if (expected > joint.torque_limit_N_m || expected < -joint.torque_limit_N_m) {
            servo = expected > 0.0 ? joint.torque_limit_N_m : -joint.torque_limit_N_m;
            giving = 0.0;
            result.at_limit |= 1U << i;
        }
        const double motor = joint.motor_inertia_kg_m2 + giving;
        const double whole = motor + yielding;
        result.motor_offset(i) = (servo - spring) / whole;
        result.motor_share(i) = yielding / whole;
        result.drive.torque_N_m(i) = spring + yielding * result.motor_offset(i);
        result.drive.armature_kg_m2(i) = yielding * (motor / whole);
    }
    return result;
}

template <class Space>
typename chain_state<Space>::vector derivative(const chain<Space> &chain, const chain_state<Space> &state,
                                               const chain_input<Space> &input, double offset_s,
                                               std::uint32_t *at_limit)
{
    const elastic_joints joints = drive_joints(chain, state, input, 0.0, offset_s, joint_vector::Zero());
    joints.note_limits(at_limit);
    const chain_acceleration<Space> acceleration = forward_dynamics(chain, state, joints.drive, input);
    chain_state<Space> rate;
    if (chain.base_is_free) {
        rate.position_m() = Space::axes_of(state.attitude()) * state.velocity();
        rate.attitude() = Space::attitude_rate(state.attitude(), state.turn_rate());
    }
    rate.link_rad() = state.link_rate();
    rate.motor_rad() = state.motor_rate();
    rate.turn_rate() = acceleration.base.angular;
    rate.velocity() = acceleration.base.linear;
    rate.link_rate() = acceleration.link_rad_per_s2;
    rate.motor_rate() = joints.motor_rad_per_s2(acceleration.link_rad_per_s2);
    rate.wheel() = -input.wheel_torque_N_m;
    return rate.values;
}

template <class Space>
tool_jacobian<Space> jacobian_of(const chain<Space> &chain, const chain_pose<Space> &pose)
{
    tool_jacobian<Space> result;
    result.joints.setZero();
    const typename Space::vector tool_m = tool_in_base(chain, pose).origin_m;
    result.base.setIdentity();
    result.base.template bottomLeftCorner<Space::dimension, Space::turns>() = Space::lever(tool_m);
    placement_of<Space> place = {Space::vector::Zero(), Space::rotation::Identity()};
    for (int i = 0; i < chain.joint_count; i++) {
        place = place * pose.links[i];
        const typename Space::angular axis = place.turn(chain.joints[i].axis.angular);
        const typename Space::vector arm_m = tool_m - place.origin_m;
        result.joints.col(i) = stacked(motion_of<Space>{axis, Space::lever(arm_m) * axis});
    }
    return result;
}

template <class Space>
chain_inertia<Space> inertia_of_chain(const chain<Space> &chain, const chain_pose<Space> &pose)
{
    chain_inertia<Space> result;
    result.joints.setZero();
    result.coupling.setZero();
    inertia_of<Space> composite = inertia_of<Space>::zero();
    for (int i = chain.joint_count - 1; i >= 0; i--) {
        composite += chain.joints[i].link;
        wrench_of<Space> wrench = composite * chain.joints[i].axis;
        result.joints(i, i) = dot(chain.joints[i].axis, wrench);
        for (int j = i - 1; j >= 0; j--) {
            wrench = pose.links[j + 1].to_parent(wrench);
            result.joints(i, j) = result.joints(j, i) = dot(chain.joints[j].axis, wrench);
        }
        result.coupling.col(i) = stacked(pose.links[0].to_parent(wrench));
        composite = pose.links[i].to_parent(composite);
    }
    composite += chain.base;
    result.base = composite;
    return result;
}

template <class Space>
wrench_of<Space> momentum(const chain<Space> &chain, const chain_state<Space> &state)
{
    const chain_pose<Space> pose = pose_of(chain, joint_vector(state.link_rad()));
    const chain_inertia<Space> inertia = inertia_of_chain(chain, pose);
    const column<Space> all = stacked(inertia.base * state.twist()) + inertia.coupling * state.link_rate();
    wrench_of<Space> in_base = {all.template head<Space::turns>(), all.template tail<Space::dimension>()};
    in_base.torque += state.wheel();
    return state.base().to_parent(in_base);
}

template <class Space>
chain_energy energy(const chain<Space> &chain, const chain_state<Space> &state)
{
    const chain_pose<Space> pose = pose_of(chain, joint_vector(state.link_rad()));
    const chain_inertia<Space> inertia = inertia_of_chain(chain, pose);
    const motion_of<Space> twist = state.twist();
    const joint_vector rates = state.link_rate();
    chain_energy result = {};
    result.kinetic_J = 0.5 * dot(twist, inertia.base * twist) + stacked(twist).dot(inertia.coupling * rates) +
                       0.5 * rates.dot(inertia.joints * rates);
    for (int i = 0; i < chain.joint_count; i++) {
        const chain_joint<Space> &joint = chain.joints[i];
        const double turn_rad = state.motor_rad()(i) - state.link_rad()(i);
        result.rotors_J += 0.5 * joint.motor_inertia_kg_m2 * state.motor_rate()(i) * state.motor_rate()(i);
        result.springs_J += 0.5 * joint.stiffness_N_m_per_rad * turn_rad * turn_rad;
    }
    return result;
}

#define FOR_EACH_SPACE(X) X(plane) X(space)
#define INSTANTIATE_DYNAMICS(Space)                                                                                 \
    template chain_pose<Space> pose_of(const chain<Space> &, const joint_vector &);                                 \
    template placement_of<Space> tool_in_base(const chain<Space> &, const chain_pose<Space> &);                     \
    template chain_acceleration<Space> forward_dynamics(const chain<Space> &, const chain_state<Space> &,           \
                                                        const joint_drive &, const chain_input<Space> &);           \
    template elastic_joints drive_joints(const chain<Space> &, const chain_state<Space> &,                          \
                                         const chain_input<Space> &, double, double, const joint_vector &);         \
    template chain_state<Space>::vector derivative(const chain<Space> &, const chain_state<Space> &,                \
                                                   const chain_input<Space> &, double, std::uint32_t *);            \
    template tool_jacobian<Space> jacobian_of(const chain<Space> &, const chain_pose<Space> &);                     \
    template chain_inertia<Space> inertia_of_chain(const chain<Space> &, const chain_pose<Space> &);                \
    template wrench_of<Space> momentum(const chain<Space> &, const chain_state<Space> &);                           \
    template chain_energy energy(const chain<Space> &, const chain_state<Space> &);
FOR_EACH_SPACE(INSTANTIATE_DYNAMICS)

} // namespace berth
