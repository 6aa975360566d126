#include "cure_search.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "../hal/rig/axes.h"
#include "../hal/rig/beam.h"
#include "../hal/rig/rig_file.h"
#include "effects/effect.h"
#include "stability/physical_parameter.h"

namespace berth
{

namespace
{

constexpr double factors[] = {1.05, 1.1, 1.2, 1.35, 1.5, 1.75, 2.0, 2.5, 3.0, 4.0, 5.5, 7.5, 10.0};
constexpr int halvings = 4;   /* of the step that a guess was found in */
constexpr int tries_most = 6; /* of `predict`, which may take a second each */
constexpr int digits = 3;

/* What makes a loop change, by how much. */
constexpr std::string_view sizes_of_change[] = {"run.dead_time_jump_ms",         "robot.dead_time_drift_ms_per_s",
                                                "object.stiffness_drift_per_s",  "robot.jitter_ms",
                                                "bus.loss_probability",          "bus.burst_probability",
                                                "bus.error_probability",         "sensor.loss_probability",
                                                "sensor.stale_probability",      "loop.lost_sample_probability",
                                                "robot.lost_command_probability"};

bool may_cure(const rig &rig, std::string_view key)
{
    const bool is_of_arm = rig.firmware.arm.kind != ARM_NONE && key.find("manipulator.") == 0;
    const bool is_of_beam = rig.object.kind == object_kind::beam && follows_from_beam(key);
    const bool is_of_object = touches_nothing(rig) && (key.find("object.") == 0 || key.find("sensor.") == 0);
    return !is_of_arm && !is_of_beam && !is_of_object && key != "sensor.stiffness_N_per_m" &&
           scale_of(key) != parameter_scale::ratio;
}

/* Axes that have the robot's dead time follow it, as those of a rig file that state none. */
void set_dead_time(rig &changed, double dead_time_ms)
{
    const double own_ms = changed.robot.dead_time_ms;
    changed.robot.dead_time_ms = dead_time_ms;
    for (side_axis_rig &axis : changed.side_axes) {
        axis.dead_time_ms = axis.dead_time_ms == own_ms ? dead_time_ms : axis.dead_time_ms;
    }
}

bool is_size_of_change(std::string_view key)
{
    return std::find(std::begin(sizes_of_change), std::end(sizes_of_change), key) != std::end(sizes_of_change);
}

/* Nor is it a cure that the tool does not arrive any more. */
bool is_cured(const growth_prediction &found)
{
    return is_stable(found) == std::optional<bool>(true) && !found.never_touches;
}

/* The search of one rig. */
class factor_search
{
  public:
    factor_search(const rig &original, const growth_predictor &guess, const growth_predictor &predict)
        : original_(original), guess_(guess), predict_(predict)
    {
    }

    std::optional<parameter_cure> nearest()
    {
        const std::vector<std::string_view> keys = curing_keys(original_);
        double before = 1.0;
        for (const double factor : factors) {
            for (const std::string_view key : keys) {
                for (const bool upwards : {false, true}) {
                    if (upwards && (is_size_of_change(key) || !may_be_raised(key))) {
                        continue;
                    }
                    if (auto found =
                            between(key, upwards ? before : 1.0 / before, upwards ? factor : 1.0 / factor)) {
                        return found;
                    }
                    if (tries_ >= tries_most) {
                        return {};
                    }
                }
            }
            before = factor;
        }
        return {};
    }

  private:
    bool is_guessed(std::string_view key, double value) const
    {
        const auto changed = with_setting(original_, key, value);
        return changed && is_stable(guess_(*changed)) == std::optional<bool>(true);
    }

    /* A cure by a factor between one that is none and one that may be. */
    std::optional<parameter_cure> between(std::string_view key, double without, double with)
    {
        const double own = value_of(original_, key);
        if (!is_guessed(key, own * with)) {
            return {};
        }
        double near = with;
        for (int i = 0; i < halvings; i++) {
            const double middle = std::sqrt(without * near);
            (is_guessed(key, own * middle) ? near : without) = middle;
        }
        for (const double factor : {near, std::sqrt(near * with), with}) {
            tries_++;
            if (auto found = tried_cure(original_, key, rounded_beyond(own * factor, own, digits), predict_)) {
                return found;
            }
        }
        return {};
    }

    const rig &original_;
    const growth_predictor &guess_;
    const growth_predictor &predict_;
    int tries_ = 0;
};

} // namespace

std::optional<rig> with_setting(const rig &original, std::string_view path, double value)
{
    const rig_key &key = *find_key(path);
    rig changed = original;
    if (path == "robot.dead_time_ms") {
        set_dead_time(changed, value);
    } else {
        *static_cast<double *>(key.member(changed)) = value;
    }
    const bool in_range = (value > key.low || (key.low_is_allowed && value == key.low)) && value <= key.high;
    if (!in_range || complete_and_check(changed)) {
        return {};
    }
    return changed;
}

double rounded_beyond(double value, double own, int to_digits)
{
    const double digit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - to_digits + 1);
    return digit * (value > own ? std::ceil(value / digit) : std::floor(value / digit));
}

std::optional<parameter_cure> tried_cure(const rig &original, std::string_view key, double value,
                                         const growth_predictor &predict)
{
    const auto changed = with_setting(original, key, value);
    if (!changed) {
        return {};
    }
    const growth_prediction found = predict(*changed);
    if (!is_cured(found)) {
        return {};
    }
    const double own = value_of(original, key);
    for (const double share : cure_safety) {
        const auto further = with_setting(original, key, value * (value > own ? 1.0 + share : 1.0 - share));
        if (further && !is_cured(predict(*further))) {
            return {};
        }
    }
    return parameter_cure{std::string(key), value_of(original, key), value, *found.growth_per_s};
}

std::vector<std::string_view> curing_keys(const rig &rig)
{
    std::vector<std::string_view> keys;
    for (const std::string_view key : physical_parameters(rig)) {
        if (may_cure(rig, key) && value_of(rig, key) > 0.0) {
            keys.push_back(key);
        }
    }
    for (const std::string_view key : sizes_of_change) {
        if (value_of(rig, key) != 0.0) {
            keys.push_back(key);
        }
    }
    return keys;
}

std::optional<parameter_cure> nearest_cure(const rig &rig, const growth_predictor &guess,
                                           const growth_predictor &predict)
{
    return factor_search(rig, guess, predict).nearest();
}

} // namespace berth
