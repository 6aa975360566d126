/* The hardware over one period of the loop: plant, reference line between setpoints, sample of the force. Exact,
 * from the same equations that the simulated rig integrates. */
#ifndef SIM_HAL_STABILITY_HARDWARE_PERIOD_H
#define SIM_HAL_STABILITY_HARDWARE_PERIOD_H

#include <array>
#include <Eigen/Core>

#include "../plant/plant.h"
#include "../solver/block_triangular.h"

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
    double advance(plant_state &state, const setpoint_window &setpoints) const;

    /* States that are in use, as plant_index; the others stay 0. Pairs that belong together are neighbours. */
    int state_count() const { return state_count_; }
    int state(int i) const { return states_[static_cast<std::size_t>(i)]; }

    /* The hardware is a chain of links of up to two states, low-pass first, each driven by those after it: its
     * eigenvalues are those of the links. */
    int link_count() const { return link_count_; }
    bool link_has_two_states(int link) const { return link_pair(link) != filter_pair || plant_.filter_order == 2; }

    /* Transition of a link over the period by itself, less 1. */
    block link_change(int link) const;

    int whole_dead_periods() const { return whole_dead_periods_; }
    int sample_age_ticks() const { return sample_age_ticks_; } /* F[n] is the sample of period n - this */
    bool needs_setpoint_before() const { return knot_ns_ > 0 || holds_; }

  private:
    /* Neighbouring states, by the place of the first of them in plant_index. */
    static constexpr int object_pair = object_position / 2;
    static constexpr int filter_pair = filter_output / 2;
    static constexpr int robot_pair = robot_position / 2;
    static constexpr int links_max = 3;

    int link_pair(int link) const { return pairs_[static_cast<std::size_t>(link)]; }

    /* A part of the period without an event: change of the links, driven by each other and by (u, u'). */
    struct part {
        std::int64_t from_ns;
        block_triangular<links_max + 1> change; /* (u, u') behind the last link */
    };

    void find_states_in_use();
    void add_part(std::int64_t from_ns, std::int64_t to_ns);
    template <int count>
    void set_change(part &made, double duration_s) const;
    reference_line line_at(const setpoint_window &setpoints, std::int64_t offset_ns, bool after_knot) const;

    plant plant_;
    std::int64_t period_ns_;
    bool holds_;
    int whole_dead_periods_;
    int sample_age_ticks_;
    std::int64_t knot_ns_;   /* offset of the reference's knot in the period: what is left of T_R */
    std::int64_t sample_ns_; /* offset of the sample in the period */
    bool samples_before_knot_;
    std::array<int, plant_state_count> states_{};
    int state_count_ = 0;
    std::array<int, links_max> pairs_{};
    int link_count_ = 0;
    std::array<part, 3> parts_;
    int part_count_ = 0;
};

} // namespace berth

#endif
