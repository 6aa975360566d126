/* The whole arm with an object at its tool as one differential equation, nothing linearised. */
#ifndef SIM_HAL_ARM_SWINGING_ARM_H
#define SIM_HAL_ARM_SWINGING_ARM_H

#include <cmath>
#include <Eigen/Core>
#include <optional>

#include "../../firmware/arm/attitude_control.h"
#include "../../firmware/arm/dynamics.h"
#include "../../hal/rig/rig_file.h"
#include "../solver/decompositions.h"
#include "../solver/factors.h"
#include "free_swing.h"

namespace berth
{

/* Motion of the arm with an object whose modes all feel the force along the direction, its tool held in what is not
 * left free: a differential equation in what differs from rest. */
template <class Space>
class swinging_arm
{
  public:
    using world_vector = typename Space::vector;
    using state_type = chain_state<Space>;

    swinging_arm(const arm_config &arm, const reduction_choice &chosen,
                 const std::vector<beam_mode> &modes_of_object)
        : config(arm), chain(make_chain<Space>(arm)), rest(state_at_start<Space>(arm)), object(modes_of_object),
          direction(chosen.direction.normalized())
    {
        rest.link_rad().head(chain.joint_count) = chosen.pose_rad;
        rest.motor_rad().head(chain.joint_count) = chosen.pose_rad;
        const placement_of<Space> tool = tool_in_world(rest);
        home = tool.origin_m;
        home_axes = tool.axes;
        const Eigen::Index across = Space::dimension - 1;
        const Eigen::Index turns = Space::dimension == 3 ? 3 : 0; /* in the plane the tool may turn */
        Eigen::MatrixXd full = Eigen::MatrixXd::Zero(1 + across + turns, motion_of<Space>::size);
        const Eigen::MatrixXd frame = orthonormal_basis(direction);
        full.row(0).tail(Space::dimension) = direction.transpose();
        full.block(1, Space::turns, across, Space::dimension) = frame.rightCols(across).transpose();
        full.bottomLeftCorner(turns, turns).setIdentity();
        held = chosen.is_guided ? full : Eigen::MatrixXd(full.topRows(1));
        base_size = chain.base_is_free ? motion_of<Space>::size : 0;
    }

    Eigen::Index states() const { return state_type::size + 2 * (modes() - 1); }
    Eigen::Index modes() const { return static_cast<Eigen::Index>(object.size()); }

    /* `deviation`: of the arm's values from rest, then places and rates of the object's further modes. */
    state_type arm_at(const Eigen::VectorXd &deviation) const
    {
        state_type state;
        state.values = rest.values + deviation.head<state_type::size>();
        state.attitude() = Space::normalised(state.attitude());
        return state;
    }

    double way_m(const Eigen::VectorXd &deviation) const
    {
        return direction.dot(tool_in_world(arm_at(deviation)).origin_m - home);
    }

    double velocity_m_per_s(const Eigen::VectorXd &deviation) const
    {
        const state_type at = arm_at(deviation);
        return (held.row(0) * jacobian(at) * rates_of(at))(0);
    }

    /* The mode's shape, turning back at `amplitude_m`; put right for what is not linear about it by the least change
     * in the measure of the inertia's diagonal. Nothing where the tool does not come so far. */
    std::optional<Eigen::VectorXd> deflected(const coupled_mode &mode, double amplitude_m) const
    {
        /* Re(c s) = 0 for the tool's way Re(c e^(s t)). */
        const std::complex<double> c(amplitude_m, amplitude_m * mode.s.real() / mode.s.imag());
        const Eigen::VectorXd q = (c * mode.shape).real();
        const Eigen::VectorXd rates = (c * mode.s * mode.shape).real();
        const Eigen::Index arm_size = q.size() - (modes() - 1);
        state_type state = rest;
        displace(state, q.head(arm_size));
        if (!lead_to(state, amplitude_m)) {
            return {};
        }
        set_rates(state, rates.head(arm_size));
        const Eigen::MatrixXd j = jacobian_of_held(state);
        set_rates(state, rates_of(state) - least_change(j, held * jacobian(state) * rates_of(state)));
        Eigen::VectorXd deviation(states());
        deviation << state.values - rest.values, q.tail(modes() - 1), rates.tail(modes() - 1);
        return deviation;
    }

    Eigen::VectorXd rate(const Eigen::VectorXd &deviation) const
    {
        const state_type at = arm_at(deviation);
        chain_input<Space> input = input_at(at);
        const elastic_joints joints = drive_joints(chain, at, input, 0.0, 0.0, joint_vector::Zero());
        const auto accelerations = [&](const Eigen::VectorXd &loads) {
            input.tool = wrench_from(loads);
            const chain_acceleration<Space> found = forward_dynamics(chain, at, joints.drive, input);
            return Eigen::VectorXd(held * tool_acceleration(at, found));
        };
        /* Loads on the tool in the directions that it is held in: accelerations there are linear in them. */
        const Eigen::Index count = held.rows();
        const Eigen::VectorXd alone = accelerations(Eigen::VectorXd::Zero(count));
        Eigen::MatrixXd by_load(count, count);
        for (Eigen::Index i = 0; i < count; i++) {
            by_load.col(i) = accelerations(Eigen::VectorXd::Unit(count, i)) - alone;
        }
        /* The object: f = m (y - sum x_i)'' + d (...)' + k (...) by its first mode, m_i x_i'' = f - d_i x_i' - k_i
         * x_i by the others. */
        const Eigen::Index others = modes() - 1;
        const auto x = deviation.segment(state_type::size, others);
        const auto v = deviation.tail(others);
        const beam_mode &first = object.front();
        double weight = 1.0;
        double known_N = first.damping_N_s_per_m * (velocity_m_per_s(deviation) - v.sum()) +
                         first.stiffness_N_per_m * (way_m(deviation) - x.sum());
        for (Eigen::Index i = 0; i < others; i++) {
            const beam_mode &mode = object[static_cast<std::size_t>(i) + 1];
            weight += first.mass_kg / mode.mass_kg;
            known_N +=
                first.mass_kg / mode.mass_kg * (mode.damping_N_s_per_m * v(i) + mode.stiffness_N_per_m * x(i));
        }
        by_load.row(0) *= first.mass_kg;
        by_load(0, 0) += weight;
        Eigen::VectorXd wanted = -alone;
        wanted(0) = first.mass_kg * wanted(0) - known_N;
        const Eigen::VectorXd loads = solution(by_load, wanted);

        input.tool = wrench_from(loads);
        Eigen::VectorXd result(states());
        result.head<state_type::size>() = derivative(chain, at, input, 0.0);
        result.segment(state_type::size, others) = v;
        for (Eigen::Index i = 0; i < others; i++) {
            const beam_mode &mode = object[static_cast<std::size_t>(i) + 1];
            result(state_type::size + others + i) =
                (-loads(0) - mode.damping_N_s_per_m * v(i) - mode.stiffness_N_per_m * x(i)) / mode.mass_kg;
        }
        return result;
    }

    void note_limits(const Eigen::VectorXd &deviation, limits_met &limits) const
    {
        const state_type at = arm_at(deviation);
        for (int i = 0; i < chain.joint_count; i++) {
            const chain_joint<Space> &joint = chain.joints[i];
            const double servo = joint.servo_stiffness_N_m_per_rad * (rest.motor_rad()(i) - at.motor_rad()(i)) -
                                 joint.servo_damping_N_m_s_per_rad * at.motor_rate()(i);
            limits.joints[i] = limits.joints[i] || std::fabs(servo) > joint.torque_limit_N_m;
        }
        if (config.attitude.actuator == ATTITUDE_WHEEL) {
            const double torque_N_m = input_at(at).wheel_torque_N_m.cwiseAbs().maxCoeff();
            const double momentum_N_m_s = at.wheel().cwiseAbs().maxCoeff();
            limits.wheel = limits.wheel || torque_N_m >= config.attitude.torque_limit_N_m;
            limits.wheel_momentum =
                limits.wheel_momentum || momentum_N_m_s >= (1.0 - 1e-9) * config.attitude.momentum_limit_N_m_s;
        }
    }

  private:
    arm_config config;
    berth::chain<Space> chain;
    state_type rest;
    std::vector<beam_mode> object;
    world_vector direction;
    world_vector home;
    typename Space::rotation home_axes;
    Eigen::MatrixXd held; /* rows: parts of the tool's twist in the world's axes; the first is along the direction */
    Eigen::Index base_size = 0;

    placement_of<Space> tool_in_world(const state_type &at) const
    {
        return at.base() * tool_in_base(chain, pose_of(chain, joint_vector(at.link_rad())));
    }

    typename Space::rotation tool_axes(const state_type &at) const { return tool_in_world(at).axes; }

    /* In the order of linear_arm. */
    Eigen::VectorXd rates_of(const state_type &at) const
    {
        Eigen::VectorXd rates(base_size + 2 * chain.joint_count);
        rates << at.values.template segment<motion_of<Space>::size>(state_type::at_twist).head(base_size),
            at.link_rate().head(chain.joint_count), at.motor_rate().head(chain.joint_count);
        return rates;
    }

    void set_rates(state_type &at, const Eigen::VectorXd &rates) const
    {
        at.values.template segment<motion_of<Space>::size>(state_type::at_twist).head(base_size) =
            rates.head(base_size);
        at.link_rate().head(chain.joint_count) = rates.segment(base_size, chain.joint_count);
        at.motor_rate().head(chain.joint_count) = rates.tail(chain.joint_count);
    }

    void displace(state_type &at, const Eigen::VectorXd &q) const
    {
        if (base_size > 0) {
            const typename Space::rotation axes = Space::axes_of(at.attitude());
            at.position_m() += axes * q.segment<Space::dimension>(Space::turns);
            at.attitude() = Space::turned_by(at.attitude(), typename Space::angular(q.head<Space::turns>()));
        }
        at.link_rad().head(chain.joint_count) += q.segment(base_size, chain.joint_count);
        at.motor_rad().head(chain.joint_count) += q.tail(chain.joint_count);
    }

    /* Twist of the tool in the world's axes by rates_of(). */
    Eigen::MatrixXd jacobian(const state_type &at) const
    {
        const tool_jacobian<Space> found = jacobian_of(chain, pose_of(chain, joint_vector(at.link_rad())));
        Eigen::MatrixXd all = Eigen::MatrixXd::Zero(motion_of<Space>::size, base_size + 2 * chain.joint_count);
        all.leftCols(base_size) = found.base.leftCols(base_size);
        all.middleCols(base_size, chain.joint_count) = found.joints.leftCols(chain.joint_count);
        const placement_of<Space> world = {world_vector::Zero(), Space::axes_of(at.attitude())};
        all.bottomRows(Space::dimension) = world.axes * all.bottomRows(Space::dimension);
        if constexpr (Space::turns == 3) {
            all.topRows(3) = world.axes * all.topRows(3);
        }
        return all;
    }

    Eigen::MatrixXd jacobian_of_held(const state_type &at) const { return held * jacobian(at); }

    /* Of q or its rates, by which J q = `wanted`. */
    Eigen::VectorXd least_change(const Eigen::MatrixXd &j, const Eigen::VectorXd &wanted) const
    {
        const Eigen::VectorXd mobility =
            linearise(config, rest.link_rad().head(chain.joint_count)).inertia.diagonal().cwiseInverse();
        const Eigen::MatrixXd by = mobility.asDiagonal() * j.transpose();
        return by * least_norm_solution(j * by, wanted);
    }

    /* What the tool is off in the directions that it is held in. */
    Eigen::VectorXd miss(const state_type &at, double amplitude_m) const
    {
        const placement_of<Space> tool = tool_in_world(at);
        Eigen::VectorXd off = Eigen::VectorXd::Zero(motion_of<Space>::size);
        off.tail(Space::dimension) = tool.origin_m - home - direction * amplitude_m;
        if constexpr (Space::turns == 3) {
            const Eigen::Matrix3d turn = tool.axes * home_axes.transpose();
            off.head(3) =
                0.5 * Eigen::Vector3d(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0), turn(1, 0) - turn(0, 1));
        }
        return held * off;
    }

    bool lead_to(state_type &at, double amplitude_m) const
    {
        constexpr int tries = 50;
        for (int i = 0; i < tries; i++) {
            const Eigen::VectorXd off = miss(at, amplitude_m);
            if (!off.allFinite()) {
                return false;
            }
            if (off.norm() <= 1e-13 * std::fabs(amplitude_m) + 1e-15 * (1.0 + home.norm())) {
                return true;
            }
            displace(at, -least_change(jacobian_of_held(at), off));
        }
        return miss(at, amplitude_m).norm() <= 1e-10 * std::fabs(amplitude_m);
    }

    wrench_of<Space> wrench_from(const Eigen::VectorXd &loads) const
    {
        const Eigen::VectorXd all = held.transpose() * loads;
        return {all.head<Space::turns>(), all.tail<Space::dimension>()};
    }

    /* Commands stand still; the wheel's control as if it had no period, but for the last millisecond before it is
     * full.
     */
    chain_input<Space> input_at(const state_type &at) const
    {
        constexpr double short_s = 1e-3;
        attitude_control<Space> control = attitude_control_at(rest);
        if (config.attitude.actuator == ATTITUDE_WHEEL) {
            attitude_control_step(control, config.attitude, short_s, at);
        }
        return {wrench_of<Space>::zero(), control.wheel_torque_N_m, Space::angular::Zero(),
                joint_vector(rest.motor_rad()), joint_vector::Zero()};
    }

    /* In the world's axes. */
    Eigen::VectorXd tool_acceleration(const state_type &at, const chain_acceleration<Space> &found) const
    {
        const chain_pose<Space> pose = pose_of(chain, joint_vector(at.link_rad()));
        motion_of<Space> motion = at.twist();
        motion_of<Space> acceleration = found.base;
        for (int i = 0; i < chain.joint_count; i++) {
            const motion_of<Space> &axis = chain.joints[i].axis;
            const motion_of<Space> turning = axis * at.link_rate()(i);
            motion = pose.links[i].to_child(motion) + turning;
            acceleration =
                pose.links[i].to_child(acceleration) + cross(motion, turning) + axis * found.link_rad_per_s2(i);
        }
        motion = chain.tool.to_child(motion);
        acceleration = chain.tool.to_child(acceleration);
        const placement_of<Space> world = {world_vector::Zero(), tool_axes(at)};
        Eigen::VectorXd all(motion_of<Space>::size);
        /* w x v: what a point feels that moves along in turning axes. */
        all << world.turn(acceleration.angular),
            world.axes * (acceleration.linear + Space::lever(motion.linear) * motion.angular);
        return all;
    }
};

} // namespace berth

#endif
