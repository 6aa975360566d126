/* The simulated force sensor's electronics: sample, bias, noise, saturation, quantisation, frames. Spring and
 * low-pass belong to the plant. Without [wrench] the sensor's other axes measure 0. With it they show the whole load
 * after crosstalk and mounting; effects act on the force along the loop alone. The weight of [tool] is included. */
#ifndef SIM_HAL_HIL_SENSOR_H
#define SIM_HAL_HIL_SENSOR_H

#include <array>
#include <memory>
#include <vector>

#include "../../hal/hal.h"
#include "../../hal/rig/wrench_matrix.h"
#include "../effects/stages.h"
#include "can_bus.h"
#include "random.h"
#include "sensor_frames.h"

namespace berth
{

class sensor
{
  public:
    explicit sensor(const rig &rig);

    std::int64_t next_sample_ns() const { return next_sample_ns_; }

    /* When the sample that is due arrives at the loop. */
    std::int64_t next_arrival_ns() const { return next_sample_ns_ + delay_ns_; }

    /* (force, torque) on the object in the robot's frame about the tool's point; N, N m. */
    using whole_load = std::array<double, 6>;

    /* Takes the sample that is due and puts its frames on the bus, so that the last one arrives one delay later; or
     * loses it. */
    void sample(const whole_load &load, can_bus &bus, bool is_lost = false);

    /* What it makes of a force: gain, bias, noise, steps, saturation. */
    double shown_N(double force_N, double time_s);

    /* Sends nothing while silent, as with its plug pulled. */
    void set_silent(bool silent) { is_silent_ = silent; }

  private:
    double felt_N(double force_N, double time_s);
    double electronics(double value, double noise, double resolution, double saturation);
    wrench shown(const whole_load &load, double time_s);

    sensor_rig rig_;
    wrench_rig wrench_;
    std::array<double, 6> tool_; /* its weight, as the sensor shows it */
    wrench_matrix shown_;        /* with [wrench] */
    bool shows_wrench_;
    random_stream random_;
    random_stream spikes_;
    double spike_probability_;
    double spike_N_;
    std::vector<std::unique_ptr<sample_stage>> stages_;
    sensor_layout layout_;
    std::size_t axis_; /* place of the force in a sample */
    std::int64_t sample_period_ns_;
    std::int64_t delay_ns_;
    std::int64_t next_sample_ns_;
    std::uint32_t counter_ = 0;
    bool is_saturated_ = false;
    bool is_silent_ = false;
    sensor_frames newest_;
};

} // namespace berth

#endif
