#include "berthing.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "../../hal/rig/rig_file.h"
#include "../solver/decompositions.h"
#include "../solver/ode.h"

namespace berth
{

namespace
{

template <class Space>
using world_vector = typename Space::vector;

template <class Vector>
Eigen::Vector3d in_space(const Vector &vector)
{
    Eigen::Vector3d all = Eigen::Vector3d::Zero();
    all.head(vector.size()) = vector;
    return all;
}

/* From 0 to 1 with rate and acceleration 0 at both ends. */
double eased(double share)
{
    const double s = std::clamp(share, 0.0, 1.0);
    return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

/* How far the tool is commanded along the direction. */
double wanted_m(const berthing_plan &plan, double time_s)
{
    const double unit_s = plan.duration_s / 60.0;
    const double reach_m = plan.gap_m + plan.press_m;
    const double swing_s = std::clamp(time_s - (plan.grip_s + 2.0 * unit_s), 0.0, 12.0 * unit_s);
    const double swing = plan.swing_m * sine_and_cosine(6.28318530717958647692 * swing_s / (4.0 * unit_s)).sine;
    return reach_m * eased(time_s / (22.0 * unit_s)) + swing -
           2.0 * plan.press_m * eased((time_s - (plan.grip_s + 15.0 * unit_s)) / (12.0 * unit_s));
}

/* The object: where it is and how fast, along the direction. */
struct object_state {
    double position_m = 0.0;
    double velocity_m_per_s = 0.0;
};

template <class Space>
struct tool_motion {
    world_vector<Space> position_m;
    world_vector<Space> velocity_m_per_s;
};

template <class Space>
class manoeuvre
{
  public:
    using vector = world_vector<Space>;

    manoeuvre(const arm_config &arm, const berthing_plan &planned)
        : plan(planned), config(arm), chain(make_chain<Space>(arm)), start(state_at_start<Space>(arm)),
          direction(planned.direction.head<Space::dimension>())
    {
        home = tool(start).position_m;
        command_rows = static_cast<int>(std::lround(plan.duration_s / plan.command_period_s));
        refuse_singular_start();
        lead_joints();
    }

    berthing_plan plan;
    arm_config config;
    berth::chain<Space> chain;
    chain_state<Space> start;
    vector direction;
    vector home; /* of the tool */
    int command_rows;
    std::vector<joint_vector> commands; /* at every command period, and one more */

    tool_motion<Space> tool(const chain_state<Space> &state) const
    {
        const chain_pose<Space> pose = pose_of(chain, joint_vector(state.link_rad()));
        const placement_of<Space> base = state.base();
        const placement_of<Space> in_base = tool_in_base(chain, pose);
        motion_of<Space> moving = state.twist();
        for (int i = 0; i < chain.joint_count; i++) {
            moving = pose.links[i].to_child(moving) + chain.joints[i].axis * state.link_rate()(i);
        }
        moving = chain.tool.to_child(moving);
        const placement_of<Space> in_world = base * in_base;
        return {in_world.origin_m, in_world.axes * moving.linear};
    }

    /* On the tool, N. */
    vector force_on_tool(const tool_motion<Space> &tool, const object_state &object, bool is_gripped,
                         const vector &grip_offset_m) const
    {
        const vector relative_m = tool.position_m - (home + direction * object.position_m);
        const vector rate = tool.velocity_m_per_s - direction * object.velocity_m_per_s;
        if (is_gripped) {
            return -plan.grip_N_per_m * (relative_m - grip_offset_m) - plan.grip_N_s_per_m * rate;
        }
        const double depth_m = relative_m.dot(direction) - plan.gap_m;
        if (depth_m <= 0.0) {
            return vector::Zero();
        }
        const double push =
            plan.contact_N_per_m * depth_m * std::max(0.0, 1.0 + plan.contact_s_per_m * rate.dot(direction));
        return -direction * push;
    }

    double object_acceleration(const object_state &object, const vector &on_tool) const
    {
        return (-on_tool.dot(direction) - plan.stiffness_N_per_m * object.position_m -
                plan.damping_N_s_per_m * object.velocity_m_per_s) /
               plan.mass_kg;
    }

    chain_input<Space> input_at(int row, const attitude_control<Space> &control) const
    {
        const auto at = static_cast<std::size_t>(row);
        return {wrench_of<Space>::zero(), control.wheel_torque_N_m, control.thruster_torque_N_m, commands[at],
                (commands[at + 1] - commands[at]) / plan.command_period_s};
    }

    berthing_sample sample(const chain_state<Space> &state, const vector &on_tool) const
    {
        const chain_energy energies = energy(chain, state);
        return {in_space(tool(state).position_m), in_space(on_tool),
                energies.kinetic_J + energies.rotors_J + energies.springs_J};
    }

  private:
    /* The tool's velocity by the joints' rates, in the world. */
    Eigen::MatrixXd tool_way(const chain_state<Space> &at) const
    {
        const tool_jacobian<Space> jacobian = jacobian_of(chain, pose_of(chain, joint_vector(at.link_rad())));
        return at.base().axes * jacobian.joints.template bottomRows<Space::dimension>().leftCols(chain.joint_count);
    }

    /* A stretched arm is not led along itself: no rates do it, or such as no joint has. A twentieth of how far a rad
     * of all joints leads is the firmware's bound, too: guidance_singular. */
    void refuse_singular_start() const
    {
        constexpr double least_share = 0.05;
        const Eigen::MatrixXd way = tool_way(start);
        const Eigen::VectorXd rates = least_norm_solution(way, direction);
        if ((way * rates - direction).norm() > 1e-6 || 1.0 < least_share * way.norm() * rates.norm()) {
            throw input_error("the arm starts at or near a singular pose, where its tool cannot be led along the "
                              "direction of the berthing; change initial_rad of its joints");
        }
    }

    /* Inverse kinematics with the base where it starts: Newton steps of least squares along the way. */
    void lead_joints()
    {
        chain_state<Space> at = start;
        const double reach_m = plan.gap_m + plan.press_m + plan.swing_m;
        for (int row = 0; row <= command_rows; row++) {
            const vector goal = home + direction * wanted_m(plan, row * plan.command_period_s);
            vector miss = goal - tool(at).position_m;
            for (int i = 0; i < 50 && miss.norm() > 1e-13; i++) {
                const Eigen::VectorXd step = least_norm_solution(tool_way(at), miss);
                at.link_rad().head(chain.joint_count) += step * std::min(1.0, 0.2 / std::max(step.norm(), 1e-300));
                miss = goal - tool(at).position_m;
            }
            if (miss.norm() > 1e-9) {
                throw input_error("the tool cannot be led " + std::to_string(reach_m) +
                                  " m along the direction from where the arm starts; it comes to a singular pose");
            }
            commands.push_back(at.link_rad());
        }
        commands.push_back(commands.back());
    }
};

template <class Space>
std::vector<joint_demand> find_demands(const arm_config &arm, const berthing_plan &plan)
{
    const manoeuvre<Space> task(arm, plan);
    std::vector<joint_demand> demands;
    for (int i = 0; i < task.chain.joint_count; i++) {
        joint_demand demand = {0.0, task.commands.front()(i), task.commands.front()(i)};
        for (std::size_t row = 1; row < task.commands.size(); row++) {
            const double angle_rad = task.commands[row](i);
            demand.rate_rad_per_s = std::max(demand.rate_rad_per_s, std::abs(angle_rad - task.commands[row - 1](i)) /
                                                                        plan.command_period_s);
            demand.least_rad = std::min(demand.least_rad, angle_rad);
            demand.most_rad = std::max(demand.most_rad, angle_rad);
        }
        demands.push_back(demand);
    }
    return demands;
}

/* States of the truth: those of the arm, the object's, and the impulse of the force. */
template <class Space>
struct true_state {
    static constexpr int at_object = chain_state<Space>::size;
    static constexpr int at_impulse = at_object + 2;
    static constexpr int size = at_impulse + Space::dimension;

    chain_state<Space> arm;
    object_state object;
    world_vector<Space> impulse_N_s;

    explicit true_state(const Eigen::VectorXd &values)
    {
        arm.values = values.head<chain_state<Space>::size>();
        arm.attitude() = Space::normalised(arm.attitude());
        object = {values(at_object), values(at_object + 1)};
        impulse_N_s = values.tail<Space::dimension>();
    }
};

template <class Space>
berthing_truth find_truth(const arm_config &arm, const berthing_plan &plan, double relative_tolerance)
{
    const manoeuvre<Space> task(arm, plan);
    using state_type = true_state<Space>;
    using vector = world_vector<Space>;
    chain_input<Space> input = {};
    double row_start_s = 0.0;
    bool is_gripped = false;
    vector grip_offset_m = vector::Zero();
    const auto force = [&](const state_type &at) {
        return task.force_on_tool(task.tool(at.arm), at.object, is_gripped, grip_offset_m);
    };
    ode equations;
    equations.rate = [&](double time_s, const Eigen::VectorXd &values) {
        const state_type at(values);
        chain_input<Space> now = input;
        now.tool.force = force(at);
        Eigen::VectorXd rate(state_type::size);
        rate << derivative(task.chain, at.arm, now, time_s - row_start_s), at.object.velocity_m_per_s,
            task.object_acceleration(at.object, now.tool.force), now.tool.force;
        return rate;
    };
    equations.event = [&](double, const Eigen::VectorXd &values) {
        const state_type at(values);
        const vector relative_m = task.tool(at.arm).position_m - task.home - task.direction * at.object.position_m;
        return is_gripped ? 1.0 : relative_m.dot(task.direction) - plan.gap_m;
    };
    ode_solver solver(equations, relative_tolerance,
                      Eigen::VectorXd::Constant(state_type::size, 1e-2 * relative_tolerance));

    berthing_truth truth;
    Eigen::VectorXd values = Eigen::VectorXd::Zero(state_type::size);
    values.head<chain_state<Space>::size>() = task.start.values;
    attitude_control<Space> control = attitude_control_at(task.start);
    const auto grid_of_row = std::lround(plan.command_period_s / truth.grid_s);
    truth.impulses_N_s.push_back(Eigen::Vector3d::Zero());
    for (int row = 0; row < task.command_rows; row++) {
        row_start_s = row * plan.command_period_s;
        const state_type before(values);
        if (!is_gripped && row_start_s >= plan.grip_s - 1e-9) {
            is_gripped = true;
            grip_offset_m = task.tool(before.arm).position_m - task.home - task.direction * before.object.position_m;
        }
        attitude_control_step(control, arm.attitude, plan.command_period_s, before.arm);
        input = task.input_at(row, control);
        std::vector<double> outputs_s;
        for (long i = 1; i < grid_of_row; i++) {
            outputs_s.push_back(row_start_s + static_cast<double>(i) * truth.grid_s);
        }
        const double end_s = (row + 1) * plan.command_period_s;
        const auto tell = [&](double, const Eigen::VectorXd &at) {
            truth.impulses_N_s.push_back(in_space(state_type(at).impulse_N_s));
        };
        for (double reached_s = row_start_s; reached_s < end_s;) {
            reached_s = solver.advance(values, reached_s, end_s, outputs_s, tell);
            truth.events += reached_s < end_s ? 1 : 0;
        }
        const state_type after(values);
        values.head<chain_state<Space>::size>() = after.arm.values;
        truth.impulses_N_s.push_back(in_space(after.impulse_N_s));
        truth.samples.push_back(task.sample(after.arm, force(after)));
    }
    return truth;
}

/* The object beside a tool on a straight line, by Runge-Kutta in steps that its own motion asks for. */
template <class Space>
object_state object_after(const manoeuvre<Space> &task, const object_state &from, const tool_motion<Space> &begin,
                          const tool_motion<Space> &end, double step_s, bool is_gripped,
                          const world_vector<Space> &grip_offset_m)
{
    const int count = std::max(1, static_cast<int>(std::lround(step_s / task.plan.object_step_s)));
    const double h = step_s / count;
    const world_vector<Space> velocity = (end.position_m - begin.position_m) / step_s;
    object_state object = from;
    const auto acceleration = [&](double time_s, const object_state &at) {
        const tool_motion<Space> tool = {begin.position_m + velocity * time_s, velocity};
        return task.object_acceleration(at, task.force_on_tool(tool, at, is_gripped, grip_offset_m));
    };
    for (int i = 0; i < count; i++) {
        const double t = i * h;
        const double x = object.position_m;
        const double v = object.velocity_m_per_s;
        const double a1 = acceleration(t, object);
        const double a2 = acceleration(t + 0.5 * h, {x + 0.5 * h * v, v + 0.5 * h * a1});
        const double a3 = acceleration(t + 0.5 * h, {x + 0.5 * h * (v + 0.5 * h * a1), v + 0.5 * h * a2});
        const double a4 = acceleration(t + h, {x + h * (v + 0.5 * h * a2), v + h * a3});
        object = {x + h * v + h * h / 6.0 * (a1 + a2 + a3), v + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)};
    }
    return object;
}

/* The step with this number, from 0, of a command period. */
template <class Space>
void advance(const chain<Space> &chain, chain_state<Space> &state, const chain_input<Space> &input,
             arm_integrator integrator, const fixed_step &step, long number)
{
    const double substep_s = step.step_s / static_cast<double>(step.substeps);
    for (std::int64_t i = 0; i < step.substeps; i++) {
        state = advanced(chain, state, input, integrator, substep_s,
                         static_cast<double>(number) * step.step_s + static_cast<double>(i) * substep_s);
    }
}

template <class Space>
std::vector<berthing_sample> step_through(const arm_config &arm, const berthing_plan &plan,
                                          arm_integrator integrator, const fixed_step &step, berthing_force force,
                                          const berthing_truth &truth)
{
    using vector = world_vector<Space>;
    const manoeuvre<Space> task(arm, plan);
    const double step_s = step.step_s;
    const long steps = std::lround(plan.command_period_s / step_s);
    const long grid = std::lround(step_s / truth.grid_s);
    chain_state<Space> state = task.start;
    attitude_control<Space> control = attitude_control_at(task.start);
    object_state object;
    bool is_gripped = false;
    vector grip_offset_m = vector::Zero();
    std::vector<berthing_sample> samples;
    std::size_t at_grid = 0;
    vector last_force = vector::Zero();
    for (int row = 0; row < task.command_rows; row++) {
        tool_motion<Space> tool = task.tool(state);
        if (!is_gripped && row * plan.command_period_s >= plan.grip_s - 1e-9) {
            is_gripped = true;
            grip_offset_m = tool.position_m - task.home - task.direction * object.position_m;
        }
        attitude_control_step(control, arm.attitude, plan.command_period_s, state);
        chain_input<Space> input = task.input_at(row, control);
        for (long i = 0; i < steps; i++) {
            if (force == berthing_force::mean) {
                const std::size_t next = at_grid + static_cast<std::size_t>(grid);
                input.tool.force =
                    ((truth.impulses_N_s[next] - truth.impulses_N_s[at_grid]) / step_s).head<Space::dimension>();
                at_grid = next;
            } else {
                const vector now = task.force_on_tool(tool, object, is_gripped, grip_offset_m);
                input.tool.force = force == berthing_force::led ? vector(1.5 * now - 0.5 * last_force) : now;
                last_force = now;
            }
            advance(task.chain, state, input, integrator, step, i);
            const tool_motion<Space> moved = task.tool(state);
            if (force != berthing_force::mean) {
                object = object_after(task, object, tool, moved, step_s, is_gripped, grip_offset_m);
            }
            tool = moved;
        }
        const vector on_tool = force == berthing_force::mean
                                   ? vector(input.tool.force)
                                   : task.force_on_tool(tool, object, is_gripped, grip_offset_m);
        samples.push_back(task.sample(state, on_tool));
    }
    return samples;
}

template <class Space>
momentum_drift drift_of(const arm_config &arm, const berthing_plan &plan, arm_integrator integrator,
                        const fixed_step &step)
{
    const manoeuvre<Space> task(arm, plan);
    const long steps = std::lround(plan.command_period_s / step.step_s);
    chain_state<Space> state = task.start;
    attitude_control<Space> control = attitude_control_at(task.start);
    momentum_drift drift;
    for (int row = 0; row < task.command_rows; row++) {
        if (arm.attitude.actuator != ATTITUDE_THRUSTERS) { /* their momentum comes from outside */
            attitude_control_step(control, arm.attitude, plan.command_period_s, state);
        }
        chain_input<Space> input = task.input_at(row, control);
        for (long i = 0; i < steps; i++) {
            advance(task.chain, state, input, integrator, step, i);
        }
        const wrench_of<Space> total = momentum(task.chain, state);
        chain_state<Space> joints_alone = state;
        joints_alone.turn_rate().setZero();
        joints_alone.velocity().setZero();
        drift.angular_N_m_s = std::max(drift.angular_N_m_s, total.torque.norm());
        drift.linear_N_s = std::max(drift.linear_N_s, total.force.norm());
        drift.moved_N_s = std::max(drift.moved_N_s, momentum(task.chain, joints_alone).force.norm());
    }
    return drift;
}

} // namespace

std::vector<joint_demand> berthing_demands(const arm_config &arm, const berthing_plan &plan)
{
    return arm.kind == ARM_PLANAR ? find_demands<plane>(arm, plan) : find_demands<space>(arm, plan);
}

berthing_truth true_berthing(const arm_config &arm, const berthing_plan &plan, double relative_tolerance)
{
    return arm.kind == ARM_PLANAR ? find_truth<plane>(arm, plan, relative_tolerance)
                                  : find_truth<space>(arm, plan, relative_tolerance);
}

std::vector<berthing_sample> stepped_berthing(const arm_config &arm, const berthing_plan &plan,
                                              arm_integrator integrator, const fixed_step &step,
                                              berthing_force force, const berthing_truth &truth)
{
    return arm.kind == ARM_PLANAR ? step_through<plane>(arm, plan, integrator, step, force, truth)
                                  : step_through<space>(arm, plan, integrator, step, force, truth);
}

momentum_drift stepped_momentum(const arm_config &arm, const berthing_plan &plan, arm_integrator integrator,
                                const fixed_step &step)
{
    return arm.kind == ARM_PLANAR ? drift_of<plane>(arm, plan, integrator, step)
                                  : drift_of<space>(arm, plan, integrator, step);
}

} // namespace berth
