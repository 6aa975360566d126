#include "arm_motion.h"

#include <cmath>
#include <new>

#include "attitude_control.h"
#include "guidance.h"
#include "integrators.h"
#include "robot_frame.h"

namespace berth
{

namespace
{

template <class Space>
struct moving_arm {
    const arm_config *config;
    chain<Space> body;
    chain_state<Space> state;
    attitude_control<Space> control;
    guidance<Space> guide;
    typename Space::vector direction;         /* of the robot, in the world ... */
    typename Space::vector direction_in_base; /* ... and in the base as it was at the start */
    double way_m;                             /* of the tool along it that counts as position 0 */
    robot_frame<Space> frame;                 /* for the robot's further axes */
    double period_s;
    std::uint32_t motors_at_limit; /* a bit a joint, in the period before */
};
static_assert(sizeof(moving_arm<plane>) <= ARM_MEMORY_BYTES && sizeof(moving_arm<space>) <= ARM_MEMORY_BYTES,
              "an arm fits into its memory");
static_assert(alignof(moving_arm<space>) <= alignof(arm_memory), "and is aligned there");

template <class Space>
moving_arm<Space> &arm_in(arm_memory &memory)
{
    return *std::launder(reinterpret_cast<moving_arm<Space> *>(memory.bytes));
}

template <class Space>
const moving_arm<Space> &arm_in(const arm_memory &memory)
{
    return *std::launder(reinterpret_cast<const moving_arm<Space> *>(memory.bytes));
}

/* Both kinds of arm begin with their configuration. */
bool is_planar(const arm_memory &memory)
{
    return arm_in<plane>(memory).config->kind == ARM_PLANAR;
}

template <class Space>
placement_of<Space> tool_in_world(const moving_arm<Space> &arm)
{
    return arm.state.base() * tool_in_base(arm.body, pose_of(arm.body, joint_vector(arm.state.link_rad())));
}

/* Where the tool is along the direction, and how fast. */
template <class Space>
void look(arm_motion &motion, const moving_arm<Space> &arm)
{
    const chain_pose<Space> pose = pose_of(arm.body, joint_vector(arm.state.link_rad()));
    const placement_of<Space> in_world = arm.state.base() * tool_in_base(arm.body, pose);
    motion_of<Space> twist = arm.state.twist();
    for (int i = 0; i < arm.body.joint_count; i++) {
        twist = pose.links[i].to_child(twist) + arm.body.joints[i].axis * arm.state.link_rate()(i);
    }
    const typename Space::vector velocity = in_world.axes * arm.body.tool.to_child(twist).linear;
    const chain_energy energies = energy(arm.body, arm.state);
    motion.position_m = arm.direction.dot(in_world.origin_m) - arm.way_m;
    motion.velocity_m_per_s = arm.direction.dot(velocity);
    motion.stored_J = energies.kinetic_J + energies.rotors_J + energies.springs_J;
}

template <class Space>
typename robot_frame<Space>::attitude tool_attitude(const moving_arm<Space> &arm)
{
    if constexpr (Space::turns == 1) {
        return arm.state.attitude()(0) + arm.state.link_rad().sum();
    } else {
        return tool_in_world(arm).axes;
    }
}

template <class Space>
void look_aside(arm_motion &motion, const moving_arm<Space> &arm)
{
    arm.frame.show(tool_in_world(arm).origin_m, tool_attitude(arm), motion.side);
}

template <class Space>
void call_sides(arm_motion &motion, const double side[SIDE_AXIS_COUNT])
{
    moving_arm<Space> &arm = arm_in<Space>(motion.memory);
    arm.frame.call(tool_in_world(arm).origin_m, tool_attitude(arm), side);
    look_aside(motion, arm);
}

template <class Space>
void start(arm_motion &motion, const arm_config &config, const double direction[3], double position_m,
           double period_s)
{
    const Eigen::Map<const Eigen::Vector3d> given(direction);
    const typename Space::vector along = given.head<Space::dimension>();
    moving_arm<Space> &arm = *new (motion.memory.bytes) moving_arm<Space>{};
    arm.config = &config;
    arm.body = make_chain<Space>(config);
    arm.state = state_at_start<Space>(config);
    arm.control = attitude_control_at(arm.state);
    arm.guide = guidance_at(arm.body, joint_vector(arm.state.motor_rad()));
    arm.direction = along / std::sqrt(along.squaredNorm());
    arm.direction_in_base = arm.state.base().axes.transpose() * arm.direction;
    arm.guide.home.origin_m -= arm.direction_in_base * position_m;
    arm.way_m = arm.direction.dot(tool_in_world(arm).origin_m) - position_m;
    arm.period_s = period_s;
    arm.frame = robot_frame<Space>::with_x_along(arm.direction);
    arm.frame.call(tool_in_world(arm).origin_m, tool_attitude(arm), motion.side);
    look(motion, arm);
}

template <class Space>
void rest_at(arm_motion &motion, double position_m)
{
    moving_arm<Space> &arm = arm_in<Space>(motion.memory);
    chain_state<Space> &state = arm.state;
    state.turn_rate().setZero();
    state.velocity().setZero();
    state.link_rate().setZero();
    state.motor_rate().setZero();
    state.motor_rad() = joint_vector(state.link_rad());
    arm.motors_at_limit = 0;
    motion.has_measured = 0;
    arm.guide = guidance_at(arm.body, joint_vector(state.motor_rad()));
    arm.guide.home.origin_m -= arm.direction_in_base * position_m;
    arm.way_m = arm.direction.dot(tool_in_world(arm).origin_m) - position_m;
    look(motion, arm);
}

template <class Space>
void take(arm_motion &motion, const arm_order &order, double operator_position_m)
{
    moving_arm<Space> &arm = arm_in<Space>(motion.memory);
    guidance_take(arm.guide, arm.body, order, arm.direction_in_base, operator_position_m);
}

/* What acts over the coming tick, see enum arm_force. */
void load_with(arm_motion &motion, const arm_load &measured)
{
    const arm_load &before = motion.has_measured ? motion.measured : measured;
    const double lead_ticks = motion.leads_force ? 0.5 : 0.0;
    motion.acting.force_N = measured.force_N + lead_ticks * (measured.force_N - before.force_N);
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        motion.acting.side[i] = measured.side[i] + lead_ticks * (measured.side[i] - before.side[i]);
    }
    motion.measured = measured;
    motion.has_measured = 1;
}

template <class Space>
void step(arm_motion &motion, const operator_command &command)
{
    moving_arm<Space> &arm = arm_in<Space>(motion.memory);
    const arm_config &config = *arm.config;
    attitude_control_step(arm.control, config.attitude, arm.period_s, arm.state);
    guidance_step(arm.guide, arm.body, config, arm.period_s, arm.direction_in_base, command.position_m,
                  command.velocity_m_per_s);
    const wrench_of<Space> push = {Space::angular::Zero(),
                                   arm.direction * (command.force_N - motion.acting.force_N)};
    const chain_input<Space> input = {push - arm.frame.load(motion.acting.side), arm.control.wheel_torque_N_m,
                                      arm.control.thruster_torque_N_m, arm.guide.motor_rad,
                                      arm.guide.motor_rad_per_s};
    const double step_s = arm.period_s / static_cast<double>(config.substeps);
    arm.motors_at_limit = 0;
    for (int64_t i = 0; i < config.substeps; i++) {
        arm.state = advanced(arm.body, arm.state, input, static_cast<arm_integrator>(config.integrator), step_s,
                             static_cast<double>(i) * step_s, &arm.motors_at_limit);
    }
    look(motion, arm);
    if (motion.has_sides) {
        look_aside(motion, arm);
    }
}

template <class Space>
void write(const moving_arm<Space> &arm, arm_record &record)
{
    const chain_state<Space> &state = arm.state;
    const typename Space::vector tool = tool_in_world(arm).origin_m;
    record.base_x_m = state.position_m()(0);
    record.base_y_m = state.position_m()(1);
    record.tool_x_m = tool(0);
    record.tool_y_m = tool(1);
    if constexpr (Space::dimension == 3) {
        record.base_z_m = state.position_m()(2);
        record.tool_z_m = tool(2);
        record.base_quaternion_w = state.attitude()(0);
        record.base_quaternion_x = state.attitude()(1);
        record.base_quaternion_y = state.attitude()(2);
        record.base_quaternion_z = state.attitude()(3);
    } else {
        record.base_turn_rad = state.attitude()(0);
    }
    double *const joints[ARM_JOINTS_MAX] = {&record.joint_0_rad, &record.joint_1_rad, &record.joint_2_rad,
                                            &record.joint_3_rad, &record.joint_4_rad, &record.joint_5_rad,
                                            &record.joint_6_rad};
    double *const motors[ARM_JOINTS_MAX] = {&record.motor_0_rad, &record.motor_1_rad, &record.motor_2_rad,
                                            &record.motor_3_rad, &record.motor_4_rad, &record.motor_5_rad,
                                            &record.motor_6_rad};
    for (int i = 0; i < arm.body.joint_count; i++) {
        *joints[i] = state.link_rad()(i);
        *motors[i] = state.motor_rad()(i);
    }
    const typename Space::angular &pulse_N_m = arm.control.thruster_torque_N_m;
    record.wheel_z_N_m_s = state.wheel()(Space::turns - 1);
    record.thruster_z_N_m = pulse_N_m(Space::turns - 1);
    if constexpr (Space::turns == 3) {
        record.wheel_x_N_m_s = state.wheel()(0);
        record.wheel_y_N_m_s = state.wheel()(1);
        record.thruster_x_N_m = pulse_N_m(0);
        record.thruster_y_N_m = pulse_N_m(1);
    }
    record.guided_by = static_cast<uint16_t>(arm.guide.active);
    record.motors_at_limit = static_cast<uint16_t>(arm.motors_at_limit);
    record.order = static_cast<uint32_t>(arm.guide.mode);
}

template <class Space>
double start_dexterity(const arm_config &config)
{
    return guidance_dexterity(make_chain<Space>(config), joint_vector(state_at_start<Space>(config).link_rad())) /
           guidance_singular;
}

} // namespace

} // namespace berth

using namespace berth;

extern "C" {

void arm_motion_start(arm_motion *motion, const arm_config *arm, const double direction[3], double position_m,
                      double period_s)
{
    *motion = {};
    if (arm->kind == ARM_PLANAR) {
        start<plane>(*motion, *arm, direction, position_m, period_s);
    } else {
        start<space>(*motion, *arm, direction, position_m, period_s);
    }
}

void arm_motion_rest_at(arm_motion *motion, double position_m)
{
    if (is_planar(motion->memory)) {
        rest_at<plane>(*motion, position_m);
    } else {
        rest_at<space>(*motion, position_m);
    }
}

void arm_motion_call_sides(arm_motion *motion, const double side[SIDE_AXIS_COUNT])
{
    if (is_planar(motion->memory)) {
        call_sides<plane>(*motion, side);
    } else {
        call_sides<space>(*motion, side);
    }
}

void arm_motion_take(arm_motion *motion, const arm_order *order, double operator_position_m)
{
    if (is_planar(motion->memory)) {
        take<plane>(*motion, *order, operator_position_m);
    } else {
        take<space>(*motion, *order, operator_position_m);
    }
}

void arm_motion_step(arm_motion *motion, const operator_command *command, double force_N)
{
    struct arm_load measured = {force_N, {}};
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        measured.side[i] = motion->side_load[i];
    }
    load_with(*motion, measured);
    if (is_planar(motion->memory)) {
        step<plane>(*motion, *command);
    } else {
        step<space>(*motion, *command);
    }
}

void arm_motion_record(const arm_motion *motion, arm_record *record)
{
    if (is_planar(motion->memory)) {
        write(arm_in<plane>(motion->memory), *record);
    } else {
        write(arm_in<space>(motion->memory), *record);
    }
}

double arm_start_dexterity(const arm_config *arm)
{
    return arm->kind == ARM_PLANAR ? start_dexterity<plane>(*arm) : start_dexterity<space>(*arm);
}
}
