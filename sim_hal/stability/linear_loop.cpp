#include "linear_loop.h"

#include <algorithm>

#include "arm_loop.h"
#include "compensation_states.h"

namespace berth
{

transition_cache::transition_cache() : kept_ns_(size), kept_(new hardware_chain::transition[size]) {}

void transition_cache::forget()
{
    std::fill(kept_ns_.begin(), kept_ns_.end(), -1);
}

linear_loop::linear_loop(const rig &rig, const loop_timeline &timeline, transition_cache &cache)
    : chain_(rig), cache_(cache), firmware_(rig.firmware), setpoints_(timeline.memory), samples_(timeline.memory),
      next_setpoint_(timeline.first_setpoint), next_sample_(timeline.first_sample)
{
    refuse_compensation(rig);
    refuse_arm(rig);
    cache_.forget();
    manipulator_start(&manipulator_, &firmware_);
    inverse_filter_start(&filter_, &firmware_);
    manipulator_.position_m = 0.0;
    manipulator_.velocity_m_per_s = 0.0;
}

void linear_loop::scale(double factor)
{
    manipulator_.position_m *= factor;
    manipulator_.velocity_m_per_s *= factor;
    for (int i = 0; i < 2; i++) {
        filter_.input_m[i] *= factor;
        filter_.output_m[i] *= factor;
    }
    state_ *= factor;
    setpoints_.scale(factor);
    samples_.scale(factor);
}

} // namespace berth
