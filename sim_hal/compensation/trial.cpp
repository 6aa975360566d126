#include "trial.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "../hil/manipulator_stand_in.h"
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
    double mean() const { return mean_; }
    double rms() const { return count_ > 0 ? std::sqrt(sum_ / static_cast<double>(count_)) : 0.0; }

  private:
    long count_ = 0;
    double mean_ = 0.0;
    double sum_ = 0.0;
};

/* Below this the steps of the wire show: 1000 times the setpoint's 10 pm. */
constexpr double height_floor_m = 1e-8;

/* Within this, a swing neither decays nor grows: by 5 % in 10 s. */
constexpr double lasting_per_s = 0.005;

/* Of the windows in which heights are looked at. */
constexpr std::size_t windows = 8;

double height_in(const std::vector<double> &position_m, std::size_t window)
{
    const auto at = [&](std::size_t w) {
        return position_m.begin() + static_cast<std::ptrdiff_t>(w * position_m.size() / windows);
    };
    const auto [low, high] = std::minmax_element(at(window), at(window + 1));
    return std::max(*high - *low, height_floor_m);
}

/* From the middle to the last window in which there is a swing: faster modes are gone by then. One that is gone
 * after the first decays at least as fast as this says. */
double growth_of(const std::vector<double> &position_m, double period_s)
{
    if (position_m.size() < 2 * windows) {
        return 0.0;
    }
    std::size_t last = windows - 1;
    while (last > 1 && height_in(position_m, last) <= height_floor_m) {
        last--;
    }
    const std::size_t first = last / 2;
    const double window_s = period_s * static_cast<double>(position_m.size()) / windows;
    return std::log(height_in(position_m, last) / height_in(position_m, first)) /
           (window_s * static_cast<double>(last - first));
}

/* Where something has been. */
struct range {
    double low = std::numeric_limits<double>::infinity();
    double high = -std::numeric_limits<double>::infinity();

    void add(double value)
    {
        low = std::min(low, value);
        high = std::max(high, value);
    }
    double furthest_from(double place) const { return std::max(high - place, place - low); }
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
    manipulator_stand_in manipulator(of);
    coupled_truth truth(of);
    spread swing;
    trial_result result{false, true, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0.0, true, fate::diverges};
    std::vector<double> position_m;
    double squares = 0.0;
    double robot_squares = 0.0;
    range of_truth_m;
    range of_loop_m;
    long ticks = 0;
    bool has_started = false;
    bool has_stopped = false;
    while (!has_stopped && manipulator.tick(hal.get(), *app)) {
        const tick_record &record = app->recorder.tick;
        const bool is_running = app->supervisor.state == SUPERVISOR_RUNNING;
        has_stopped = has_started && !is_running;
        if (!is_running) {
            continue;
        }
        if (!has_started) {
            truth.start(record.manipulator_position_m, record.manipulator_velocity_m_per_s,
                        1e-9 * static_cast<double>(record.scheduled_ns));
            has_started = true;
        }
        const double off_m = record.manipulator_position_m - truth.position_m();
        squares += off_m * off_m;
        const double robot_off_m = sim_rig(hal.get()).truth().robot_position_m - record.manipulator_position_m;
        robot_squares += robot_off_m * robot_off_m;
        swing.add(truth.position_m());
        result.peak_error_m = std::max(result.peak_error_m, std::abs(off_m));
        result.peak_force_N = std::max(result.peak_force_N, std::abs(record.force_N));
        result.limited_ticks += record.limits != 0;
        of_truth_m.add(truth.position_m());
        of_loop_m.add(record.manipulator_position_m);
        position_m.push_back(record.manipulator_position_m);
        ticks++;
        truth.advance(app->operator_channel.command);
    }
    result.ran = has_started && !has_stopped;
    /* About the middle of the motion: where zero lies says nothing. */
    result.is_bounded =
        ticks == 0 || of_loop_m.furthest_from(swing.mean()) <= 2.0 * of_truth_m.furthest_from(swing.mean());
    result.swing_m = swing.rms();
    const auto share_of_swing = [&](double sum_of_squares) {
        return ticks > 0 && swing.rms() > 0.0 ? std::sqrt(sum_of_squares / static_cast<double>(ticks)) / swing.rms()
                                              : 0.0;
    };
    result.error = share_of_swing(squares);
    result.robot_error = share_of_swing(robot_squares);
    result.growth_per_s = growth_of(position_m, config_period_s(&of.firmware));
    if (!result.ran && result.growth_per_s < 1.0 / duration_s) {
        result.growth_per_s = 1.0 / duration_s;
        result.has_growth = false;
    }
    result.fate = result.growth_per_s < -lasting_per_s  ? fate::decays
                  : result.growth_per_s < lasting_per_s ? fate::lasts
                                                        : fate::diverges;
    return result;
}

} // namespace berth
