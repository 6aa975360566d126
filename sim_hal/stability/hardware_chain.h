/* The hardware between events as a chain of links of up to two states, sensor first, each driven by those after it:
 * the plant's equations, solved exactly for one straight line of the reference. The modes of a beam, or a mass that
 * hangs on the object, make links with it that drive each other: they are turned so that each drives only those
 * before it. */
#ifndef SIM_HAL_STABILITY_HARDWARE_CHAIN_H
#define SIM_HAL_STABILITY_HARDWARE_CHAIN_H

#include <array>

#include "../plant/plant.h"
#include "../solver/block_triangular.h"

namespace berth
{

class hardware_chain
{
  public:
    static constexpr int plain_links_max = 7;
    static constexpr int links_max = plain_links_max - 2 + beam_modes_max - 1; /* no further body on a beam */

    /* Change of the links over a duration, driven by each other and by (u, u') behind the last link. */
    using transition = block_triangular<links_max + 1>;

    /* Throws input_error for rigs that are not linear: contact. */
    explicit hardware_chain(const rig &rig);

    const plant &equations() const { return plant_; }

    /* What the loop gets of the force that the sensor measures, for a setpoint as it is sent. */
    double sampled_N(double measured_N) const { return gain_ * measured_N; }

    /* States that are in use, as plant_index; the others stay 0. Pairs that belong together are neighbours. */
    int state_count() const { return state_count_; }
    int state(int i) const { return states_[static_cast<std::size_t>(i)]; }

    int link_count() const { return link_count_; }
    bool link_has_two_states(int link) const
    {
        const int pair = link_pair(link);
        return pair != robot_lag_pair && pair != sensor_lag_pair &&
               (pair != filter_pair || plant_.filter_order == 2);
    }

    void set_transition(transition &made, double duration_s) const;

    void advance(beam_state &state, const transition &change, const reference_line &line) const
    {
        const pair_vector inputs{line.position_m, line.velocity_m_per_s};
        turn(state, into_links_);
        for (int row = 0; row < link_count_; row++) { /* those behind it have not moved yet */
            const pair_vector sum = change_of_link(row, state, change, inputs);
            state(first_state(link_pair(row))) += sum[0];
            state(first_state(link_pair(row)) + 1) += sum[1];
        }
        turn(state, out_of_links_);
    }

    /* The plant's states as states of the links, each pair in its place, and back. */
    beam_state in_links(beam_state state) const
    {
        turn(state, into_links_);
        return state;
    }
    beam_state out_of_links(beam_state links) const
    {
        turn(links, out_of_links_);
        return links;
    }

    /* By how much the links' states change. */
    beam_state change_of_links(const beam_state &links, const transition &change, const reference_line &line) const
    {
        const pair_vector inputs{line.position_m, line.velocity_m_per_s};
        beam_state changed = beam_state::Zero();
        for (int row = 0; row < link_count_; row++) {
            const pair_vector sum = change_of_link(row, links, change, inputs);
            changed.segment<2>(first_state(link_pair(row))) << sum[0], sum[1];
        }
        return changed;
    }

    /* Place of the first of a link's states. */
    Eigen::Index link_place(int link) const { return first_state(link_pair(link)); }

  private:
    /* Neighbouring states, by the place of the first of them in plant_index. */
    static constexpr int object_pair = object_position / 2;
    static constexpr int filter_pair = filter_output / 2;
    static constexpr int robot_pair = robot_position / 2;
    static constexpr int second_pair = second_position / 2;
    static constexpr int robot_lag_pair = lagged_position / 2;
    static constexpr int sensor_lag_pair = lagged_force / 2;
    static constexpr int relaxed_pair = relaxed_position / 2;

    /* Object, and its further modes, or a second mass and what relaxes. */
    static constexpr int body_states_max = 2 * beam_modes_max;
    using body_matrix =
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, body_states_max, body_states_max>;
    using body_vector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, body_states_max, 1>;

    static body_matrix block_triangular_basis(const body_matrix &a);

    /* From the plant's states into those of the links or back. */
    template <typename state_type>
    void turn(state_type &state, const body_matrix &turned) const
    {
        if (body_state_count_ > 2) {
            body_vector all(body_state_count_);
            for (int i = 0; i < body_state_count_; i++) {
                all(i) = state(body_place(i));
            }
            const body_vector after = turned * all;
            for (int i = 0; i < body_state_count_; i++) {
                state(body_place(i)) = after(i);
            }
        }
    }
    void separate_bodies();

    /* In plant_index, or behind it. */
    Eigen::Index body_place(int i) const { return body_pairs_[static_cast<std::size_t>(i / 2)] * 2 + i % 2; }

    pair_vector change_of_link(int row, const beam_state &links, const transition &change, pair_vector inputs) const
    {
        pair_vector sum = change.at(row, link_count_) * inputs;
        for (int column = row; column < link_count_; column++) {
            sum += change.at(row, column) * pair_of(links, link_pair(column));
        }
        return sum;
    }

    int link_pair(int link) const { return pairs_[static_cast<std::size_t>(link)]; }
    static Eigen::Index first_state(int pair) { return 2 * static_cast<Eigen::Index>(pair); }
    template <typename state_type>
    static pair_vector pair_of(const state_type &state, int pair)
    {
        return pair_vector{state(first_state(pair)), state(first_state(pair) + 1)};
    }

    template <int count, typename state_type>
    void set_blocks(transition &made, double duration_s) const;

    plant plant_;
    double gain_; /* of setpoints and samples together */
    std::array<int, beam_state_count> states_{};
    int state_count_ = 0;
    std::array<int, links_max> pairs_{};
    int link_count_ = 0;
    std::array<int, beam_modes_max> body_pairs_{object_pair};
    int body_state_count_ = 2;
    body_matrix into_links_;
    body_matrix out_of_links_;
    beam_state scales_; /* of the links' states */
};

} // namespace berth

#endif
