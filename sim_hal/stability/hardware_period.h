/* The hardware over one period of the loop: plant, reference line between setpoints, sample of the force. Exact,
 * from the same equations that the simulated rig integrates. */
#ifndef SIM_HAL_STABILITY_HARDWARE_PERIOD_H
#define SIM_HAL_STABILITY_HARDWARE_PERIOD_H

#include <array>

#include "hardware_chain.h"

namespace berth
{

/* The setpoints that shape the reference in period n, T_R being whole_dead_periods and a rest: */
struct setpoint_window {
    double next_m;   /* x[n - whole_dead_periods + 1]: the goal of the line after the knot ("linear") */
    double now_m;    /* x[n - whole_dead_periods]: passed at the knot */
    double before_m; /* x[n - whole_dead_periods - 1] */
};

class hardware_period
{
  public:
    /* Throws input_error for rigs that are not linear or not the same in every period: contact, free robot clock. */
    explicit hardware_period(const rig &rig);

    /* One period ahead; returns the force sample taken in it, in N. */
    double advance(beam_state &state, const setpoint_window &setpoints) const;

    /* By how much the links' states change, kept apart from them: what changes little keeps its digits. */
    struct change {
        beam_state links;
        double sample_N;
    };
    change change_of(const beam_state &links, const setpoint_window &setpoints) const;

    /* See hardware_chain. Its eigenvalues are those of its links. */
    int state_count() const { return chain_.state_count(); }
    int state(int i) const { return chain_.state(i); }
    int link_count() const { return chain_.link_count(); }
    bool link_has_two_states(int link) const { return chain_.link_has_two_states(link); }
    Eigen::Index link_place(int link) const { return chain_.link_place(link); }

    /* Transition of a link over the period by itself, less 1. */
    two_by_two link_change(int link) const;

    int whole_dead_periods() const { return whole_dead_periods_; }
    int sample_age_ticks() const { return sample_age_ticks_; } /* F[n] is the sample of period n - this */
    std::int64_t sample_age_ns() const { return sample_age_ticks_ * period_ns_ - sample_ns_; } /* at a tick */
    bool needs_setpoint_before() const { return knot_ns_ > 0 || holds_; }

  private:
    /* A part of the period without an event. */
    struct part {
        std::int64_t from_ns;
        hardware_chain::transition change;
    };

    /* What happens in the period, in its order: calls sample(line), jump(way in m), travel(transition, line). */
    template <typename sample, typename jump, typename travel>
    void pass(const setpoint_window &setpoints, const sample &take_sample, const jump &do_jump,
              const travel &do_travel) const;

    void add_part(std::int64_t from_ns, std::int64_t to_ns);
    reference_line line_at(const setpoint_window &setpoints, std::int64_t offset_ns, bool after_knot) const;

    hardware_chain chain_;
    std::array<part, 3> parts_;
    std::int64_t period_ns_;
    std::int64_t knot_ns_;   /* offset of the reference's knot in the period: what is left of T_R */
    std::int64_t sample_ns_; /* offset of the sample in the period */
    int whole_dead_periods_;
    int sample_age_ticks_;
    int part_count_ = 0;
    bool holds_;
    bool samples_before_knot_;
};

} // namespace berth

#endif
