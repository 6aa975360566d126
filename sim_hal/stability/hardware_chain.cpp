#include "hardware_chain.h"

#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"

namespace berth
{

hardware_chain::hardware_chain(const rig &rig) : plant_(rig), gain_(gain_when_small(rig))
{
    if (rig.object.kind == object_kind::contact) {
        throw input_error("object.kind: one-sided contact has no eigenvalues; look at a gripped object of the same "
                          "stiffness, or at the growth that `berth run` measures");
    }
    const auto use = [&](int first, int count) {
        for (int i = 0; i < count; i++) {
            states_[static_cast<std::size_t>(state_count_++)] = first + i;
        }
    };
    const auto link = [&](int pair) { pairs_[static_cast<std::size_t>(link_count_++)] = pair; };
    if (plant_.filter_order > 0) {
        link(filter_pair);
    }
    use(object_position, 2);
    link(object_pair);
    if (plant_.has_transfer_behaviour) {
        use(robot_position, 2);
        link(robot_pair);
    }
    use(filter_output, static_cast<int>(plant_.filter_order));
}

void hardware_chain::set_transition(transition &made, double duration_s) const
{
    switch (link_count_) {
    case 1:
        return set_blocks<2>(made, duration_s);
    case 2:
        return set_blocks<3>(made, duration_s);
    default:
        return set_blocks<4>(made, duration_s);
    }
}

/* exp of the plant's equations, asked for unit vectors so that they stand in one place only, in natural units, so
 * that no digits are lost between metres and newtons. */
template <int count>
void hardware_chain::set_blocks(transition &made, double duration_s) const
{
    constexpr int inputs = count - 1;
    const plant_state zero = plant_state::Zero();
    const plant_state natural = plant_.natural_scales();
    std::array<pair_vector, count> scales;
    for (int i = 0; i < inputs; i++) {
        scales[static_cast<std::size_t>(i)] = pair_of(natural, link_pair(i));
    }
    scales[inputs] = pair_vector{1.0, 1.0 / duration_s}; /* the slope counts in metres per part */

    block_triangular<count> generator;
    const auto set_column = [&](int column, int side, const plant_state &rate) {
        for (int row = 0; row <= std::min(column, inputs - 1); row++) {
            generator.at(row, column).columns[static_cast<std::size_t>(side)] = pair_of(rate, link_pair(row));
        }
    };
    for (int i = 0; i < inputs; i++) {
        set_column(i, 0, plant_.derivative(plant_state::Unit(first_state(link_pair(i))), {}));
        set_column(i, 1, plant_.derivative(plant_state::Unit(first_state(link_pair(i)) + 1), {}));
    }
    set_column(inputs, 0, plant_.derivative(zero, {1.0, 0.0}));
    set_column(inputs, 1, plant_.derivative(zero, {0.0, 1.0}));
    generator.at(inputs, inputs) = {pair_vector{0.0, 0.0}, pair_vector{1.0, 0.0}}; /* u grows by its slope */

    std::array<pair_vector, count> inverse_scales;
    for (std::size_t i = 0; i < count; i++) {
        inverse_scales[i] = 1.0 / scales[i];
    }
    generator.for_each([&](int row, int column) {
        block &entry = generator.at(row, column);
        const pair_vector from = scales[static_cast<std::size_t>(column)] * duration_s;
        const pair_vector to = inverse_scales[static_cast<std::size_t>(row)];
        entry.columns[0] *= to * from[0];
        entry.columns[1] *= to * from[1];
    });
    const block_triangular<count> change = exponential_minus_identity(generator);
    change.for_each([&](int row, int column) {
        block &entry = made.at(row, column);
        const pair_vector from = inverse_scales[static_cast<std::size_t>(column)];
        const pair_vector to = scales[static_cast<std::size_t>(row)];
        entry.columns[0] = change.at(row, column).columns[0] * to * from[0];
        entry.columns[1] = change.at(row, column).columns[1] * to * from[1];
    });
}

} // namespace berth
