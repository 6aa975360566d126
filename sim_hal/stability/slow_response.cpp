#include "slow_response.h"

#include <algorithm>
#include <array>

namespace berth
{

namespace
{

/* Two of a link's states. */
using polynomial_pair = std::array<short_polynomial, 2>;

void add(short_polynomial &sum, double factor, const short_polynomial &p)
{
    sum.degree = std::max(sum.degree, p.degree);
    for (int i = 0; i <= p.degree; i++) {
        sum.coefficients[static_cast<std::size_t>(i)] += factor * p.coefficients[static_cast<std::size_t>(i)];
    }
}

/* A setpoint at rest, on its way before the knot and after it; how much there is of each where setpoints go as z^n,
 * w^2 left out: w (now), w (1 - w) (now less the one before), 1 - w (the next less now). */
struct input {
    setpoint_window setpoints;
    short_factor share; /* by powers of d */
};
constexpr std::array<input, 3> inputs{{
    {{1.0, 1.0, 1.0}, {1.0, 1.0, 0.0, 1}},
    {{0.0, 0.0, -1.0}, {0.0, 1.0, 0.0, 1}},
    {{1.0, 0.0, 0.0}, {0.0, 1.0, 1.0, 2}},
}};

short_polynomial polynomial_of(const short_factor &f)
{
    short_polynomial one;
    one.coefficients[0] = 1.0;
    multiply(one, f);
    return one;
}

/* det(d - n) of the change n of a link. */
short_factor poles_of(const two_by_two &n, bool has_two_states)
{
    return has_two_states ? short_factor{n.determinant(), -n.trace(), 1.0, 2} : short_factor{-n(0, 0), 1.0, 0.0, 1};
}

/* adj(d - n) driven */
polynomial_pair answer(const two_by_two &n, bool has_two_states, const polynomial_pair &driven)
{
    if (!has_two_states) {
        return {driven[0], {}};
    }
    polynomial_pair x = driven;
    multiply(x[0], {-n(1, 1), 1.0, 0.0, 1});
    add(x[0], n(0, 1), driven[1]);
    multiply(x[1], {-n(0, 0), 1.0, 0.0, 1});
    add(x[1], n(1, 0), driven[0]);
    return x;
}

} // namespace

/* (d - N) x = what drives, N block triangular: from the last link to the first, which drive those before them and
 * the sample. Everything over one denominator, that of the links so far. Nothing is left of a difference of what is
 * nearly equal but where robot and object move alike, and there as much as the spring's own force. */
short_polynomial slow_response(const hardware_period &hardware)
{
    std::array<polynomial_pair, hardware_chain::links_max> driven{};
    short_polynomial sample;
    const auto drive = [&](int links, const hardware_period::change &by, const short_polynomial &p) {
        for (int i = 0; i < links; i++) {
            const Eigen::Index place = hardware.link_place(i);
            add(driven[static_cast<std::size_t>(i)][0], by.links(place), p);
            add(driven[static_cast<std::size_t>(i)][1], by.links(place + 1), p);
        }
        add(sample, by.sample_N, p);
    };
    for (const input &part : inputs) {
        drive(hardware.link_count(), hardware.change_of(beam_state::Zero(), part.setpoints),
              polynomial_of(part.share));
    }
    for (int link = hardware.link_count() - 1; link >= 0; link--) {
        const bool has_two_states = hardware.link_has_two_states(link);
        const two_by_two n = hardware.link_change(link);
        const polynomial_pair x = answer(n, has_two_states, driven[static_cast<std::size_t>(link)]);
        const short_factor poles = poles_of(n, has_two_states);
        multiply(sample, poles);
        for (int i = 0; i < link; i++) {
            multiply(driven[static_cast<std::size_t>(i)][0], poles);
            multiply(driven[static_cast<std::size_t>(i)][1], poles);
        }
        for (int side = 0; side < (has_two_states ? 2 : 1); side++) {
            const beam_state unit = beam_state::Unit(hardware.link_place(link) + side);
            drive(link, hardware.change_of(unit, {}), x[static_cast<std::size_t>(side)]);
        }
    }
    return sample;
}

} // namespace berth
