#include "arm_at_states.h"

#include <nlohmann/json.hpp>

#include "../../firmware/arm/dynamics.h"
#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

using nlohmann::json;

template <class Vector>
json as_json(const Vector &vector)
{
    json list = json::array();
    for (Eigen::Index i = 0; i < vector.size(); i++) {
        list.push_back(vector(i));
    }
    return list;
}

json rows_as_json(const Eigen::MatrixXd &matrix)
{
    json rows = json::array();
    for (Eigen::Index i = 0; i < matrix.rows(); i++) {
        rows.push_back(as_json(matrix.row(i)));
    }
    return rows;
}

/* Reads numbers of one state; remembers which keys it was asked for. */
class state_reader
{
  public:
    state_reader(const json &state, std::string where) : state_(state), where_(std::move(where))
    {
        if (!state.is_object()) {
            throw input_error(where_ + ": must be an object");
        }
    }

    template <class Vector>
    void read(const char *key, Vector &&values, Eigen::Index count)
    {
        known_.push_back(key);
        const auto found = state_.find(key);
        if (found == state_.end()) {
            return;
        }
        bool fits = found->is_array() && found->size() == static_cast<std::size_t>(count);
        for (Eigen::Index i = 0; fits && i < count; i++) {
            const json &value = (*found)[static_cast<std::size_t>(i)];
            fits = value.is_number();
            values(i) = fits ? value.template get<double>() : 0.0;
        }
        if (!fits) {
            throw input_error(where_ + "." + key + ": must be " + std::to_string(count) + " numbers");
        }
    }

    void refuse_others() const
    {
        for (const auto &[key, value] : state_.items()) {
            if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
                std::string names;
                for (const std::string &known : known_) {
                    names += (names.empty() ? "" : ", ") + known;
                }
                throw input_error(std::string(where_).append(".").append(key).append(": unknown key; there are ") +
                                  names);
            }
        }
    }

  private:
    const json &state_;
    std::string where_;
    std::vector<std::string> known_;
};

/* The forces of velocities alone, base first: what it takes that nothing accelerates, by the recursive Newton-Euler
 * algorithm (Featherstone 2008, chapter 5.3). To every digit, as nothing is solved for; and for a base of no mass.
 */
template <class Space>
Eigen::VectorXd bias_of(const chain<Space> &chain, const chain_pose<Space> &pose, const chain_state<Space> &state)
{
    const int n = chain.joint_count;
    motion_of<Space> motions[ARM_JOINTS_MAX + 1] = {state.twist()}; /* base first */
    wrench_of<Space> wrenches[ARM_JOINTS_MAX + 1];
    motion_of<Space> acceleration = motion_of<Space>::zero();
    wrenches[0] = cross(motions[0], chain.base * motions[0]);
    wrenches[0].torque += Space::cross(motions[0].angular, typename Space::angular(state.wheel()));
    for (int i = 0; i < n; i++) {
        const inertia_of<Space> &link = chain.joints[i].link;
        const motion_of<Space> turning = chain.joints[i].axis * state.link_rate()(i);
        motions[i + 1] = pose.links[i].to_child(motions[i]) + turning;
        acceleration = pose.links[i].to_child(acceleration) + cross(motions[i + 1], turning);
        wrenches[i + 1] = link * acceleration + cross(motions[i + 1], link * motions[i + 1]);
    }
    constexpr int size = motion_of<Space>::size;
    Eigen::VectorXd bias(size + n);
    for (int i = n - 1; i >= 0; i--) {
        bias(size + i) = dot(chain.joints[i].axis, wrenches[i + 1]);
        wrenches[i] = wrenches[i] + pose.links[i].to_parent(wrenches[i + 1]);
    }
    bias.head(size) << wrenches[0].torque, wrenches[0].force;
    return bias;
}

template <class Space>
json at_state(const chain<Space> &chain, const json &given, const std::string &where)
{
    const int n = chain.joint_count;
    chain_state<Space> state;
    state.attitude() = Space::no_turn();
    chain_input<Space> input = {wrench_of<Space>::zero(), Space::angular::Zero(), Space::angular::Zero(),
                                joint_vector::Zero(), joint_vector::Zero()};
    joint_drive drive = {joint_vector::Zero(), joint_vector::Zero()};
    state_reader reader(given, where);
    reader.read("position_m", state.position_m(), Space::dimension);
    reader.read("attitude", state.attitude(), Space::attitude_size);
    reader.read("turn_rate_rad_per_s", state.turn_rate(), Space::turns);
    reader.read("velocity_m_per_s", state.velocity(), Space::dimension);
    reader.read("link_rad", state.link_rad(), n);
    reader.read("link_rad_per_s", state.link_rate(), n);
    reader.read("torque_N_m", drive.torque_N_m, n);
    reader.read("tool_torque_N_m", input.tool.torque, Space::turns);
    reader.read("tool_force_N", input.tool.force, Space::dimension);
    reader.read("wheel_N_m_s", state.wheel(), Space::turns);
    reader.refuse_others();

    const chain_pose<Space> pose = pose_of(chain, joint_vector(state.link_rad()));
    const chain_inertia<Space> inertia = inertia_of_chain(chain, pose);
    constexpr int size = motion_of<Space>::size;
    Eigen::MatrixXd all(size + n, size + n);
    all << inertia.base.matrix(), inertia.coupling.leftCols(n), inertia.coupling.leftCols(n).transpose(),
        inertia.joints.topLeftCorner(n, n);
    const chain_acceleration<Space> found = forward_dynamics(chain, state, drive, input);
    Eigen::VectorXd acceleration(size + n);
    acceleration << found.base.angular, found.base.linear, found.link_rad_per_s2.head(n);
    const wrench_of<Space> total = momentum(chain, state);
    const chain_energy energies = energy(chain, state);
    const tool_jacobian<Space> jacobian = jacobian_of(chain, pose);
    Eigen::MatrixXd jacobians(size, size + n);
    jacobians << jacobian.base, jacobian.joints.leftCols(n);
    return {{"inertia", rows_as_json(all)},
            {"bias", as_json(bias_of(chain, pose, state))},
            {"acceleration", as_json(acceleration)},
            {"momentum", {{"angular", as_json(total.torque)}, {"linear", as_json(total.force)}}},
            {"kinetic_J", energies.kinetic_J},
            {"tool_m", as_json((state.base() * tool_in_base(chain, pose)).origin_m)},
            {"jacobian", rows_as_json(jacobians)}};
}

} // namespace

json arm_at_states(const arm_config &config, const json &states, const std::string &origin)
{
    if (!states.is_array()) {
        throw input_error(origin + ": must be a list of states in brackets");
    }
    json results = json::array();
    for (std::size_t i = 0; i < states.size(); i++) {
        const std::string where = origin + ": state " + std::to_string(i);
        results.push_back(config.kind == ARM_PLANAR ? at_state(make_chain<plane>(config), states[i], where)
                                                    : at_state(make_chain<space>(config), states[i], where));
    }
    return results;
}

} // namespace berth
