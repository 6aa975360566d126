/* The loop along a timeline, in double precision: firmware's manipulator and inverse filter, exact solver of the
 * plant, without noise, limits and the steps of frames. */
#ifndef SIM_HAL_STABILITY_LINEAR_LOOP_H
#define SIM_HAL_STABILITY_LINEAR_LOOP_H

#include <cstdint>
#include <memory>
#include <vector>

#include "../../firmware/inverse_filter.h"
#include "../../firmware/manipulator.h"
#include "hardware_chain.h"
#include "loop_timeline.h"

namespace berth
{

/* Transitions of the hardware by their duration: a few that come again and again, or all different. */
class transition_cache
{
  public:
    transition_cache();

    /* Of the one chain that is asked for since the last forget(). */
    const hardware_chain::transition &over(const hardware_chain &chain, std::int64_t duration_ns)
    {
        const auto hash = static_cast<std::uint64_t>(duration_ns) * 0x9e3779b97f4a7c15u;
        const std::size_t place = hash >> (64 - size_bits);
        if (kept_ns_[place] != duration_ns) {
            chain.set_transition(kept_[place], static_cast<double>(duration_ns) * 1e-9);
            kept_ns_[place] = duration_ns;
        }
        return kept_[place];
    }
    void forget();

  private:
    static constexpr int size_bits = 11;
    static constexpr std::size_t size = std::size_t{1} << size_bits;
    std::vector<std::int64_t> kept_ns_;
    std::unique_ptr<hardware_chain::transition[]> kept_;
};

/* Values by their running number; old ones are forgotten. */
class value_memory
{
  public:
    explicit value_memory(std::int32_t size) : values_(static_cast<std::size_t>(size)), mask_(size - 1) {}
    double &at(std::int32_t number) { return values_[static_cast<std::size_t>(number & mask_)]; }
    void scale(double factor)
    {
        for (double &value : values_) {
            value *= factor;
        }
    }

  private:
    std::vector<double> values_;
    std::int32_t mask_;
};

class linear_loop
{
  public:
    linear_loop(const rig &rig, const loop_timeline &timeline, transition_cache &cache);
    linear_loop(const linear_loop &) = delete; /* parts of it point at others */
    linear_loop &operator=(const linear_loop &) = delete;

    void advance(const timeline_step &step)
    {
        switch (step.what) {
        case timeline_step::kind::tick:
            return tick(step);
        case timeline_step::kind::sample:
            samples_.at(next_sample_++) =
                chain_.sampled_N(chain_.equations().measured_force_N(state_, line_of(step)));
            return;
        case timeline_step::kind::jump:
            chain_.equations().apply_reference_jump(state_, setpoints_.at(step.to) - setpoints_.at(step.from));
            return;
        case timeline_step::kind::travel:
            chain_.advance(state_, cache_.over(chain_, step.duration_ns), line_of(step));
            return;
        }
    }

    double position_m() const { return manipulator_.position_m; }
    void push(double distance_m) { manipulator_.position_m += distance_m; }

    /* It is linear: as much smaller or larger it goes the same way. */
    void scale(double factor);

  private:
    void tick(const timeline_step &step)
    {
        setpoints_.at(next_setpoint_++) = inverse_filter_step(&filter_, manipulator_.position_m);
        const operator_command rest{};
        manipulator_step(&manipulator_, &rest, samples_.at(step.from));
    }
    reference_line line_of(const timeline_step &step)
    {
        const double from_m = setpoints_.at(step.from);
        const double way_m = setpoints_.at(step.to) - from_m;
        return {from_m + way_m * step.share, way_m * step.share_per_s};
    }

    hardware_chain chain_;
    transition_cache &cache_;
    app_config firmware_;
    manipulator manipulator_;
    inverse_filter filter_;
    beam_state state_ = beam_state::Zero();
    value_memory setpoints_;
    value_memory samples_;
    std::int32_t next_setpoint_;
    std::int32_t next_sample_;
};

} // namespace berth

#endif
