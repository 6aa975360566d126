#include "trial.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "../../firmware/loop.h"
#include "../hil/sim_hal.h"
#include "coupled_truth.h"

namespace berth
{

namespace
{

/* Mean of squares about the mean. */
class spread
{
  public:
    void add(double value)
    {
        count_++;
        const double step = value - mean_;
        mean_ += step / static_cast<double>(count_);
        sum_ += step * (value - mean_);
    }
    double rms() const { return count_ > 0 ? std::sqrt(sum_ / static_cast<double>(count_)) : 0.0; }

  private:
    long count_ = 0;
    double mean_ = 0.0;
    double sum_ = 0.0;
};

struct hal_closer {
    void operator()(struct hal *hal) const { hal_close(hal); }
};

} // namespace

trial_result run_trial(const rig &rig, double duration_s)
{
    berth::rig of = rig;
    of.run.duration_s = of.run.release_s + duration_s;
    const std::unique_ptr<struct hal, hal_closer> hal(sim_open(of));
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &of.firmware);
    coupled_truth truth(of);
    spread swing;
    trial_result result{false, true, 0.0, 0.0, 0.0, 0};
    double squares = 0.0;
    double largest_truth_m = 0.0;
    double largest_m = 0.0;
    long ticks = 0;
    bool has_started = false;
    bool has_stopped = false;
    while (!has_stopped && loop_tick(hal.get(), app.get()) == HAL_OK) {
        const tick_record &record = app->record;
        const bool is_running = app->supervisor.state == SUPERVISOR_RUNNING;
        has_stopped = has_started && !is_running;
        if (!is_running) {
            continue;
        }
        if (!has_started) {
            truth.start(record.manipulator_position_m, record.manipulator_velocity_m_per_s);
            has_started = true;
        }
        const double off_m = record.manipulator_position_m - truth.position_m();
        squares += off_m * off_m;
        swing.add(truth.position_m());
        result.peak_error_m = std::max(result.peak_error_m, std::abs(off_m));
        result.peak_force_N = std::max(result.peak_force_N, std::abs(record.force_N));
        result.limited_ticks += record.limits != 0;
        largest_truth_m = std::max(largest_truth_m, std::abs(truth.position_m()));
        largest_m = std::max(largest_m, std::abs(record.manipulator_position_m));
        ticks++;
        truth.advance(app->operator_channel.command);
    }
    result.ran = has_started && !has_stopped;
    result.is_bounded = largest_m <= 2.0 * largest_truth_m;
    const double rms_m = ticks > 0 ? std::sqrt(squares / static_cast<double>(ticks)) : 0.0;
    result.error = swing.rms() > 0.0 ? rms_m / swing.rms() : 0.0;
    return result;
}

} // namespace berth
