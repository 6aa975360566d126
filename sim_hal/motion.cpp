#include "motion.h"

#include <algorithm>
#include <cmath>

#include "../firmware/pi.h"
#include "delay_budget.h"
#include "hil/profile.h"
#include "stability/equivalent_loop.h"

namespace berth
{

namespace
{

/* The setpoint's step: less than that never comes to the robot. */
constexpr double stands_still_m = 1e-11;

constexpr std::size_t least_heights = 8;

/* What acts beyond this share of the run acts to its end. */
constexpr double late = 0.75;

/* A motion that an operator's profile moves for more than this share of the run is the operator's. */
constexpr double driven_share = 0.5;

/* What moves little more than this share of its first half in its second has come to rest; in between, a slow growth
 * may be hidden in what the release has left. */
constexpr double comes_to_rest = 0.2;

/* A force that grows, and is not the same swing seen at another phase. */
constexpr double grows_by = 2.0;

/* A swing is lower, or of the same height as before, by this factor. */
constexpr double falls_by = 0.9;

double range_of(std::vector<double>::const_iterator from, std::vector<double>::const_iterator to)
{
    const auto [low, high] = std::minmax_element(from, to);
    return *high - *low;
}

/* What fell may level out and rise again, slowly: to its end it falls, or is at rest. */
bool falls_on(const std::vector<double> &signal, double at_first)
{
    constexpr double at_rest = 0.02; /* of the height at first: noise */
    const auto eighth = static_cast<std::ptrdiff_t>(signal.size() / 8);
    const double before = range_of(signal.end() - 2 * eighth, signal.end() - eighth);
    const double last = range_of(signal.end() - eighth, signal.end());
    return last <= falls_by * before || last <= at_rest * at_first;
}

motion_trend trend_of(const std::vector<double> &running_m)
{
    const auto middle = running_m.begin() + static_cast<std::ptrdiff_t>(running_m.size() / 2);
    const double first = range_of(running_m.begin(), middle);
    const double second = range_of(middle, running_m.end());
    if (second > first) {
        return motion_trend::moves_more;
    }
    return second <= comes_to_rest * first && falls_on(running_m, first) ? motion_trend::comes_to_rest
                                                                         : motion_trend::unknown;
}

double median_height(std::vector<oscillation_height>::const_iterator from,
                     std::vector<oscillation_height>::const_iterator to)
{
    std::vector<double> values;
    std::transform(from, to, std::back_inserter(values), [](const oscillation_height &h) { return h.value; });
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/* Frequency of the second half of the swings, in Hz: two heights a period. 0: there are too few. */
double swing_of(const std::vector<oscillation_height> &heights)
{
    if (heights.size() < least_heights) {
        return 0.0;
    }
    const std::size_t first = heights.size() / 2;
    const auto count = static_cast<double>(heights.size() - 1 - first);
    return 0.5 * count / (heights.back().time_s - heights[first].time_s);
}

/* Limits bound the motion: does it fall nevertheless? While they act to the end, a fall is theirs, too. */
std::optional<bool> falls_nevertheless(const std::vector<oscillation_height> &heights, double limited_share)
{
    constexpr double end = 0.9; /* of the run */
    if (heights.size() < least_heights) {
        return {};
    }
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    const bool is_lower = median_height(middle, heights.end()) < falls_by * median_height(heights.begin(), middle);
    if (is_lower && limited_share > end) {
        return {};
    }
    return is_lower;
}

/* It would have swung often enough with more time. What is seen to be slower than the manipulator counts as it is.
 */
bool is_too_short(const std::vector<oscillation_height> &heights, double duration_s, const rig &rig)
{
    const manipulator_config &manipulator = rig.firmware.manipulator;
    const double half_swing_s = manipulator.stiffness_N_per_m > 0.0
                                    ? pi * std::sqrt(manipulator.mass_kg / manipulator.stiffness_N_per_m)
                                    : 0.0;
    const std::size_t count = heights.size();
    const double seen_s = count >= 2 ? heights[count - 1].time_s - heights[count - 2].time_s : 0.0;
    return count < least_heights && duration_s < least_heights * std::max(half_swing_s, seen_s);
}

/* The tick of a time of the run, or the next one. */
bool is_in_tick(const rig &rig, double at_s, std::int64_t tick)
{
    const std::int64_t period_ns = config_period_ns(&rig.firmware);
    return at_s > 0.0 && at_s < never && (event_ns(at_s) + period_ns - 1) / period_ns == tick;
}

/* An order sets the arm in motion: what moves then has not grown out of what moved before. */
bool is_ordered_in(const rig &rig, std::int64_t tick)
{
    return std::any_of(rig.orders.begin(), rig.orders.end(), [&](const operator_order &order) {
        return is_in_tick(rig, rig.run.release_s + order.at_s, tick);
    });
}

/* A tool in contact has no gripper: there is a loop as soon as it has touched. */
bool is_held(const rig &rig, const tick_record &record)
{
    if (touches_nothing(rig)) {
        return true;
    }
    return rig.object.kind == object_kind::contact
               ? record.robot_position_m > rig.object.surface_position_m
               : config_period_ns(&rig.firmware) * record.index >= event_ns(rig.run.grip_close_s);
}

bool is_let_go(const rig &rig, std::int64_t tick)
{
    return config_period_s(&rig.firmware) * static_cast<double>(tick) >= rig.run.grip_release_s;
}

/* Until when the operator's profile moves, since the release. */
double profile_ends_s(const profile_rig &profile, operator_interface interface)
{
    const double amplitude = interface == OPERATOR_INTERFACE_FORCE ? profile.amplitude_N : profile.amplitude_m;
    switch (profile.kind) {
    case profile_kind::rest:
        return 0.0;
    case profile_kind::step:
        return amplitude != 0.0 ? profile.start_s : 0.0;
    case profile_kind::ramp:
    case profile_kind::minimum_jerk:
    case profile_kind::chirp:
        return amplitude != 0.0 ? profile.start_s + profile.duration_s : 0.0;
    case profile_kind::file:
        return never;
    default:
        return amplitude != 0.0 ? never : 0.0;
    }
}

bool is_driven(const rig &rig, double running_s)
{
    const auto interface = static_cast<operator_interface>(rig.firmware.operator_command.interface);
    const double moved_s = profile_ends_s(rig.profile, interface) - rig.profile.start_s;
    return moved_s > driven_share * running_s;
}

} // namespace

double speed_at_surface_m_per_s(const rig &rig, const tick_record &record)
{
    const manipulator_config &manipulator = rig.firmware.manipulator;
    if (rig.firmware.arm.kind != ARM_NONE || rig.firmware.operator_command.interface != OPERATOR_INTERFACE_MOTION) {
        return record.manipulator_velocity_m_per_s; /* where its spring is at rest is not known */
    }
    const double way_m = record.manipulator_position_m - record.operator_position_m;
    const double way_at_surface_m = rig.object.surface_position_m - record.operator_position_m;
    const double w2_per_s2 = manipulator.stiffness_N_per_m / (manipulator.mass_kg + rig.object.mass_kg);
    const double v_m_per_s = record.manipulator_velocity_m_per_s;
    const double square = v_m_per_s * v_m_per_s + w2_per_s2 * (way_m * way_m - way_at_surface_m * way_at_surface_m);
    return std::copysign(std::sqrt(std::max(0.0, square)), v_m_per_s);
}

bool run_stop::is_of_motion() const
{
    return cause == STOP_POSITION_LIMIT || cause == STOP_FORCE_LIMIT || cause == STOP_SENSOR_SATURATED ||
           cause == STOP_NOT_FINITE;
}

motion_recorder::motion_recorder(const rig &rig) : rig_(rig), period_s_(config_period_s(&rig.firmware))
{
    constexpr double settled = 3.0; /* delays of the loop: the low-pass has died down to a few percent */
    settle_ticks_ = 1 + static_cast<std::int64_t>(settled * 1e-3 * delay_budget_of(rig).total_ms() / period_s_);
    evidence_.is_contact = rig.object.kind == object_kind::contact;
    evidence_.is_ordered = !rig.orders.empty();
    evidence_.has_effects_of_size = !effects_of_size(rig).empty();
}

void motion_recorder::forget_motion()
{
    newest_ = {};
    longest_ = {};
    running_m_.clear();
    running_N_.clear();
    limited_until_tick_ = 0;
}

void motion_recorder::end_free_motion()
{
    if (newest_.tick.size() > longest_.tick.size()) {
        std::swap(newest_, longest_);
    }
    newest_.position_m.clear();
    newest_.tick.clear();
    newest_.motor_limit_ticks = 0;
}

void motion_recorder::note_peaks(const tick_record &record, std::optional<double> spring_force_N)
{
    const double now_s = period_s_ * static_cast<double>(record.index);
    if (std::abs(record.force_N) > evidence_.measured_peak.force_N) {
        evidence_.measured_peak = {std::abs(record.force_N), now_s};
    }
    if (!spring_force_N) {
        return;
    }
    if (!evidence_.true_peak || std::abs(*spring_force_N) > evidence_.true_peak->force_N) {
        evidence_.true_peak = force_peak{std::abs(*spring_force_N), now_s};
    }
}

/* The manipulator feels a stay only after the loop's delay: it has the speed of before when the robot touches, and
 * that of after once the last force has reached it. */
void motion_recorder::note_bounce(const tick_record &record)
{
    if (!evidence_.is_contact) {
        return;
    }
    const double now_s = period_s_ * static_cast<double>(record.index);
    const double speed_m_per_s = speed_at_surface_m_per_s(rig_, record);
    const double robot_m_per_s = (record.robot_position_m - robot_before_m_) / period_s_;
    const double depth_m = record.robot_position_m - rig_.object.surface_position_m;
    const bool pushes =
        rig_.object.stiffness_N_per_m * depth_m + rig_.object.damping_N_s_per_m * robot_m_per_s > 0.0;
    if (holds_ && !open_bounce_) {
        open_bounce_ = bounce{now_s, now_s, speed_m_per_s, 0.0};
        operator_before_J_ = record.energy_operator_J;
    }
    if (holds_ && pushes) {
        open_bounce_->left_s = now_s + period_s_;
    }
    if (holds_) {
        settled_in_tick_ = -1;
    } else if (open_bounce_ && settled_in_tick_ < 0) {
        settled_in_tick_ = record.index + settle_ticks_;
    } else if (open_bounce_ && record.index >= settled_in_tick_) {
        open_bounce_->speed_out_m_per_s = -speed_m_per_s;
        const bool has_arm = rig_.firmware.arm.kind != ARM_NONE; /* whose joints' orders are no work on the tool */
        open_bounce_->operator_J = has_arm ? 0.0 : record.energy_operator_J - operator_before_J_;
        open_bounce_->speed_noise_m_per_s = rig_.sensor.noise_N / rig_.firmware.manipulator.mass_kg *
                                            std::sqrt(period_s_ * (now_s - open_bounce_->touched_s));
        if (open_bounce_->speed_in_m_per_s > 0.0 && open_bounce_->speed_out_m_per_s > 0.0) {
            evidence_.bounces.push_back(*open_bounce_);
        }
        open_bounce_.reset();
    }
}

/* Neither the dampers' share, which comes after the limit, nor the sensor's own limit counts. */
void motion_recorder::note_led_force(const tick_record &record)
{
    const app_config &config = rig_.firmware;
    const double limit_N = config.sensor_channel.force_limit_N;
    const bool is_led = config.force_lead.enabled || config.prediction.enabled;
    if (!is_led || std::abs(record.used_force_N) < limit_N) {
        return;
    }
    if (led_ticks_ == 0) {
        evidence_.led = force_at_limit{limit_N, period_s_ * static_cast<double>(record.index)};
        led_before_ticks_ = running_ticks_ - 1;
    }
    led_ticks_++;
    led_until_ticks_ = running_ticks_;
}

void motion_recorder::note_running(const tick_record &record)
{
    running_ticks_++;
    note_led_force(record);
    limited_ticks_ += record.limits != 0;
    holds_ = is_held(rig_, record);
    held_ticks_ += holds_;
    note_bounce(record);
    robot_before_m_ = record.robot_position_m;
    const double error_m = record.robot_position_m - record.manipulator_position_m;
    tracking_square_sum_m2_ += error_m * error_m;
    evidence_.tracking.peak_m = std::max(evidence_.tracking.peak_m, std::abs(error_m));
    lowest_m_ =
        running_ticks_ == 1 ? record.manipulator_position_m : std::min(lowest_m_, record.manipulator_position_m);
    highest_m_ =
        running_ticks_ == 1 ? record.manipulator_position_m : std::max(highest_m_, record.manipulator_position_m);
    running_m_.add(record.manipulator_position_m);
    running_N_.add(std::abs(record.force_N));
    limited_until_tick_ = record.limits != 0 ? running_m_.added() : limited_until_tick_;
}

void motion_recorder::note_tick(const tick_record &record, bool motors_at_limit,
                                std::optional<double> spring_force_N)
{
    if (is_in_tick(rig_, rig_.run.grip_close_s, record.index)) {
        forget_motion(); /* before the object is gripped there is no loop that could grow */
    }
    if (is_ordered_in(rig_, record.index)) {
        end_free_motion();
    }
    const auto cause = static_cast<stop_cause>(record.stop_cause);
    if (cause != evidence_.stop.cause) {
        evidence_.stop = {cause, period_s_ * static_cast<double>(record.index)};
    }
    note_peaks(record, spring_force_N);
    const bool is_running = record.state == SUPERVISOR_RUNNING;
    if (is_running) {
        note_running(record);
    }
    if (is_running && record.limits == 0 && !is_let_go(rig_, record.index)) {
        newest_.position_m.push_back(record.manipulator_position_m);
        newest_.tick.push_back(record.index);
        newest_.motor_limit_ticks += motors_at_limit;
        if (newest_.tick.size() == kept_ticks_max) {
            end_free_motion();
        }
    } else {
        end_free_motion();
    }
}

motion_evidence motion_recorder::conclude()
{
    end_free_motion();
    motion_evidence &found = evidence_;
    found.running_s = period_s_ * static_cast<double>(running_ticks_);
    found.has_run = running_ticks_ > 0;
    found.has_touched = held_ticks_ > 0;
    found.touches_now = holds_;
    found.is_driven = is_driven(rig_, found.running_s);
    found.tracking.range_m = highest_m_ - lowest_m_;
    found.tracking.rms_m =
        found.has_run ? std::sqrt(tracking_square_sum_m2_ / static_cast<double>(running_ticks_)) : 0.0;
    if (found.has_run) {
        found.limited_share = static_cast<double>(limited_ticks_) / static_cast<double>(running_ticks_);
    }
    if (found.led) {
        found.led->share = static_cast<double>(led_ticks_) / static_cast<double>(running_ticks_ - led_before_ticks_);
        found.led->is_late = static_cast<double>(led_until_ticks_) > late * static_cast<double>(running_ticks_);
    }
    if (found.has_touched) {
        found.growth = fit_growth(longest_.position_m, period_s_, growth_floor_m);
    }
    if (!longest_.tick.empty()) {
        found.motor_limit_share =
            static_cast<double>(longest_.motor_limit_ticks) / static_cast<double>(longest_.tick.size());
    }
    const std::vector<double> &positions_m = running_m_.values();
    if (positions_m.size() < least_heights) {
        return found;
    }
    found.has_moved = range_of(positions_m.begin(), positions_m.end()) > stands_still_m;
    const double sample_s = period_s_ * static_cast<double>(running_m_.stride());
    const std::vector<oscillation_height> heights = oscillation_heights(positions_m, sample_s);
    const double limited_share = static_cast<double>(limited_until_tick_) / static_cast<double>(running_m_.added());
    found.limits_acted_late = limited_share > late;
    found.falls = falls_nevertheless(heights, limited_share);
    found.height_m =
        heights.size() < least_heights
            ? 0.0
            : median_height(heights.end() - static_cast<std::ptrdiff_t>(least_heights / 2), heights.end());
    found.swing_Hz = swing_of(heights);
    found.is_too_short = is_too_short(heights, period_s_ * static_cast<double>(running_m_.added()), rig_);
    found.trend = trend_of(positions_m);
    const std::vector<double> &forces_N = running_N_.values();
    const auto middle = forces_N.begin() + static_cast<std::ptrdiff_t>(forces_N.size() / 2);
    const double first_N = *std::max_element(forces_N.begin(), middle);
    const double second_N = *std::max_element(middle, forces_N.end());
    found.force_grows = second_N > grows_by * first_N;
    found.force_falls = second_N < falls_by * first_N;
    return found;
}

} // namespace berth
