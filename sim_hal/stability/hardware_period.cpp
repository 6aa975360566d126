#include "hardware_period.h"

#include <algorithm>

#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

/* At a tick, of the newest sample that has arrived by then. */
std::int64_t newest_sample_age_ns(const rig &rig)
{
    if (rig.has_wandering_samples()) {
        throw input_error(
            "sensor.rate_Hz: where its period, in whole ns, does not go into that of loop.rate_Hz the age of the "
            "force changes from period to period and there are no eigenvalues; look at the growth that "
            "`berth eigen` tells");
    }
    return rig.sample_age_ns();
}

} // namespace

hardware_period::hardware_period(const rig &rig)
    : chain_(rig), period_ns_(config_period_ns(&rig.firmware)),
      holds_(rig.robot.interpolation == interpolation::hold)
{
    if (rig.robot.clock == robot_clock::free) {
        throw input_error("robot.clock: with a free clock the loop changes from period to period and has no "
                          "eigenvalues; use \"locked\", or look at the growth that `berth eigen` tells");
    }
    const std::int64_t dead_time_ns = command_to_motion_ns(rig);
    whole_dead_periods_ = static_cast<int>(dead_time_ns / period_ns_);
    knot_ns_ = dead_time_ns % period_ns_;
    samples_before_knot_ = dead_time_ns == 0; /* a sample cannot know of a setpoint that is sent after it */
    const std::int64_t age_ns = newest_sample_age_ns(rig);
    sample_age_ticks_ = static_cast<int>((age_ns + period_ns_ - 1) / period_ns_);
    sample_ns_ = sample_age_ticks_ * period_ns_ - age_ns;

    std::array<std::int64_t, 4> instants{0, knot_ns_, sample_ns_, period_ns_};
    std::sort(instants.begin(), instants.end());
    for (std::size_t i = 1; i < instants.size(); i++) {
        if (instants[i] > instants[i - 1]) {
            add_part(instants[i - 1], instants[i]);
        }
    }
}

void hardware_period::add_part(std::int64_t from_ns, std::int64_t to_ns)
{
    part &made = parts_[static_cast<std::size_t>(part_count_++)];
    made.from_ns = from_ns;
    chain_.set_transition(made.change, static_cast<double>(to_ns - from_ns) * 1e-9);
}

reference_line hardware_period::line_at(const setpoint_window &setpoints, std::int64_t offset_ns,
                                        bool after_knot) const
{
    if (holds_) {
        return {after_knot ? setpoints.now_m : setpoints.before_m, 0.0};
    }
    const double change_m = after_knot ? setpoints.next_m - setpoints.now_m : setpoints.now_m - setpoints.before_m;
    const double slope_m_per_s = change_m / (static_cast<double>(period_ns_) * 1e-9);
    return {setpoints.now_m + slope_m_per_s * static_cast<double>(offset_ns - knot_ns_) * 1e-9, slope_m_per_s};
}

template <typename sample, typename jump, typename travel>
void hardware_period::pass(const setpoint_window &setpoints, const sample &take_sample, const jump &do_jump,
                           const travel &do_travel) const
{
    for (int i = 0; i < part_count_; i++) {
        const part &piece = parts_[static_cast<std::size_t>(i)];
        if (piece.from_ns == sample_ns_ && samples_before_knot_) {
            take_sample(line_at(setpoints, piece.from_ns, false));
        }
        if (piece.from_ns == knot_ns_ && holds_) {
            do_jump(setpoints.now_m - setpoints.before_m);
        }
        const reference_line line = line_at(setpoints, piece.from_ns, piece.from_ns >= knot_ns_);
        if (piece.from_ns == sample_ns_ && !samples_before_knot_) {
            take_sample(line);
        }
        do_travel(piece.change, line);
    }
}

double hardware_period::advance(beam_state &state, const setpoint_window &setpoints) const
{
    double sample_N = 0.0;
    pass(
        setpoints, [&](const reference_line &line) { sample_N = chain_.equations().measured_force_N(state, line); },
        [&](double way_m) { chain_.equations().apply_reference_jump(state, way_m); },
        [&](const hardware_chain::transition &over, const reference_line &line) {
            chain_.advance(state, over, line);
        });
    return chain_.sampled_N(sample_N);
}

hardware_period::change hardware_period::change_of(const beam_state &links, const setpoint_window &setpoints) const
{
    change made{beam_state::Zero(), 0.0};
    pass(
        setpoints,
        [&](const reference_line &line) {
            const beam_state state = chain_.out_of_links(links + made.links);
            made.sample_N = chain_.sampled_N(chain_.equations().measured_force_N(state, line));
        },
        [&](double way_m) {
            beam_state jumped = beam_state::Zero();
            chain_.equations().apply_reference_jump(jumped, way_m);
            made.links += chain_.in_links(jumped);
        },
        [&](const hardware_chain::transition &over, const reference_line &line) {
            made.links += chain_.change_of_links(links + made.links, over, line);
        });
    return made;
}

two_by_two hardware_period::link_change(int link) const
{
    two_by_two product = parts_[0].change.at(link, link);
    for (int i = 1; i < part_count_; i++) { /* (1 + b)(1 + a) - 1 */
        const two_by_two &after = parts_[static_cast<std::size_t>(i)].change.at(link, link);
        const two_by_two before = product;
        for (std::size_t c = 0; c < 2; c++) {
            product.columns[c] += after.columns[c] + after * before.columns[c];
        }
    }
    return product;
}

} // namespace berth
