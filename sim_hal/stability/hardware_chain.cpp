#include "hardware_chain.h"

#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"
#include "../solver/decompositions.h"
#include "../solver/factors.h"

namespace berth
{

/* Orthogonal q, so that q^T a q is block upper triangular, of 2x2 blocks. Schur's form is, unless a pair of complex
 * eigenvalues comes to stand across two of them, after a real one: then the pair's own plane comes first, and what
 * is behind it is looked at anew. */
hardware_chain::body_matrix hardware_chain::block_triangular_basis(const body_matrix &a)
{
    const Eigen::Index count = a.rows();
    body_matrix basis = body_matrix::Identity(count, count);
    body_matrix rest = a;
    for (Eigen::Index first = 0; first + 2 < count; first += 2) {
        const Eigen::Index left = count - first;
        const schur_form schur = real_schur(rest);
        const body_matrix t = schur.t;
        body_matrix turned = schur.u;
        if (t(2, 1) != 0.0) { /* t (x, 1)' = (x, 1)' pair in the first three */
            const Eigen::Matrix2d pair = t.block<2, 2>(1, 1);
            const Eigen::Matrix2d apart = pair - t(0, 0) * Eigen::Matrix2d::Identity();
            const Eigen::Matrix2d back = inverse(apart);
            Eigen::Matrix<double, 3, 2> plane;
            plane << t.block<1, 2>(0, 1) * back, Eigen::Matrix2d::Identity();
            const Eigen::Matrix3d first_three = orthonormal_basis(plane);
            turned.leftCols<3>() = (turned.leftCols<3>() * first_three).eval();
        }
        basis.rightCols(left) = (basis.rightCols(left) * turned).eval();
        const body_matrix after = turned.transpose() * rest * turned;
        rest = after.bottomRightCorner(left - 2, left - 2);
    }
    return basis;
}

hardware_chain::hardware_chain(const rig &rig)
    : plant_(rig), gain_(touches_nothing(rig) ? 0.0 : gain_when_small(rig)),
      scales_(plant_.natural_scales<beam_state>())
{
    if (rig.object.kind == object_kind::contact) {
        throw input_error(
            "object.kind: one-sided contact has no eigenvalues for small motions; give an --amplitude, look "
            "at a gripped object of the same stiffness, or at the growth that `berth run` measures");
    }
    const auto use = [&](int first, int count) {
        for (int i = 0; i < count; i++) {
            states_[static_cast<std::size_t>(state_count_++)] = first + i;
        }
    };
    const auto link = [&](int pair) { pairs_[static_cast<std::size_t>(link_count_++)] = pair; };
    if (plant_.sensor_lag_s > 0.0) {
        link(sensor_lag_pair);
    }
    if (plant_.filter_order > 0) {
        link(filter_pair);
    }
    use(object_position, 2);
    link(object_pair);
    const auto add_body = [&](int pair) {
        use(2 * pair, 2);
        link(pair);
        body_pairs_[static_cast<std::size_t>(body_state_count_ / 2)] = pair;
        body_state_count_ += 2;
    };
    if (plant_.second_mass_kg > 0.0) {
        add_body(second_pair);
    }
    if (plant_.relaxation_N_per_m > 0.0) {
        add_body(relaxed_pair);
    }
    for (int i = 0; i < plant_.further_mode_count; i++) {
        add_body(static_cast<int>(further_position(i)) / 2);
    }
    if (body_state_count_ > 2) {
        separate_bodies();
    }
    if (plant_.robot_lag_s > 0.0) {
        use(lagged_position, 1);
        link(robot_lag_pair);
    }
    if (plant_.has_transfer_behaviour) {
        use(robot_position, 2);
        link(robot_pair);
    }
    use(filter_output, static_cast<int>(plant_.filter_order));
    if (plant_.sensor_lag_s > 0.0) {
        use(lagged_force, 1);
    }
}

/* In natural units, which the links' states keep. */
void hardware_chain::separate_bodies()
{
    const int count = body_state_count_;
    body_matrix a(count, count);
    body_vector scales(count);
    for (int column = 0; column < count; column++) {
        const beam_state rate = plant_.derivative(beam_state(beam_state::Unit(body_place(column))), {});
        scales(column) = scales_(body_place(column));
        for (int row = 0; row < count; row++) {
            a(row, column) = rate(body_place(row));
        }
    }
    const body_matrix basis = block_triangular_basis(scales.cwiseInverse().asDiagonal() * a * scales.asDiagonal());
    into_links_ = basis.transpose() * scales.cwiseInverse().asDiagonal();
    out_of_links_ = scales.asDiagonal() * basis;
    for (int i = 0; i < count; i++) {
        scales_(body_place(i)) = 1.0;
    }
}

void hardware_chain::set_transition(transition &made, double duration_s) const
{
    if (plant_.further_mode_count > 0) {
        return set_blocks<links_max + 1, beam_state>(made, duration_s);
    }
    switch (link_count_) {
    case 1:
        return set_blocks<2, plant_state>(made, duration_s);
    case 2:
        return set_blocks<3, plant_state>(made, duration_s);
    case 3:
        return set_blocks<4, plant_state>(made, duration_s);
    default:
        return set_blocks<plain_links_max + 1, plant_state>(made, duration_s);
    }
}

/* exp of the plant's equations, asked for unit vectors so that they stand in one place only, in natural units, so
 * that no digits are lost between metres and newtons. */
template <int count, typename state_type>
void hardware_chain::set_blocks(transition &made, double duration_s) const
{
    const int inputs = count <= 4 ? count - 1 : link_count_; /* what comes behind them stays 0 */
    const state_type zero = state_type::Zero();
    std::array<pair_vector, count> scales;
    scales.fill(pair_vector{1.0, 1.0});
    for (int i = 0; i < inputs; i++) {
        scales[static_cast<std::size_t>(i)] = pair_of(scales_, link_pair(i));
    }
    scales[static_cast<std::size_t>(inputs)] =
        pair_vector{1.0, 1.0 / duration_s}; /* the slope counts in metres per part */

    block_triangular<count> generator{};
    const auto set_column = [&](int column, int side, state_type rate) {
        turn(rate, into_links_);
        for (int row = 0; row <= std::min(column, inputs - 1); row++) {
            generator.at(row, column).columns[static_cast<std::size_t>(side)] = pair_of(rate, link_pair(row));
        }
    };
    for (int i = 0; i < inputs; i++) {
        for (int side = 0; side < 2; side++) {
            state_type state = state_type::Unit(first_state(link_pair(i)) + side);
            turn(state, out_of_links_);
            set_column(i, side, plant_.derivative(state, {}));
        }
    }
    set_column(inputs, 0, plant_.derivative(zero, {1.0, 0.0}));
    set_column(inputs, 1, plant_.derivative(zero, {0.0, 1.0}));
    generator.at(inputs, inputs) = {pair_vector{0.0, 0.0}, pair_vector{1.0, 0.0}}; /* u grows by its slope */

    std::array<pair_vector, count> inverse_scales;
    for (std::size_t i = 0; i < count; i++) {
        inverse_scales[i] = 1.0 / scales[i];
    }
    generator.for_each([&](int row, int column) {
        two_by_two &entry = generator.at(row, column);
        const pair_vector from = scales[static_cast<std::size_t>(column)] * duration_s;
        const pair_vector to = inverse_scales[static_cast<std::size_t>(row)];
        entry.columns[0] *= to * from[0];
        entry.columns[1] *= to * from[1];
    });
    const block_triangular<count> change = exponential_minus_identity(generator);
    change.for_each([&](int row, int column) {
        two_by_two &entry = made.at(row, column);
        const pair_vector from = inverse_scales[static_cast<std::size_t>(column)];
        const pair_vector to = scales[static_cast<std::size_t>(row)];
        entry.columns[0] = change.at(row, column).columns[0] * to * from[0];
        entry.columns[1] = change.at(row, column).columns[1] * to * from[1];
    });
}

} // namespace berth
