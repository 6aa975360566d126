#include "reduction.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "../../firmware/pi.h"
#include "../../hal/rig/axes.h"
#include "../../hal/rig/rig_file.h"
#include "spectrum.h"

namespace berth
{

namespace
{

constexpr double softer_min = 0.01;
constexpr double stiffer_max = 1e4;
constexpr double longer_max = 10.0;  /* of the rig's own dead time: how far the longest is looked for */
constexpr double shorter_min = 0.01; /* of a period: where it begins for a robot without one */
/* Beyond so many periods the loop has so many states that every eigenvalue takes a second. */
constexpr double periods_max = 200.0;

swing swing_of(std::complex<double> s)
{
    return {s.imag() / two_pi, -s.real() / std::abs(s)};
}

swing coupled_of(const rig &rig, const arm_mode &mode)
{
    const double mass = mode.mass_kg + rig.object.mass_kg;
    const double w = std::sqrt((mode.stiffness_N_per_m + rig.object.stiffness_N_per_m) / mass);
    const double decay = (mode.damping_N_s_per_m + rig.object.damping_N_s_per_m) / (2.0 * mass);
    return {std::sqrt(std::max(0.0, w * w - decay * decay)) / two_pi, decay / w};
}

using growth_of_rig = std::function<double(const rig &)>;

/* Between a value at which the loop is stable and one at which it grows: the last stable one, halved down. */
double edge_between(double stable, double unstable, const std::function<double(double)> &growth)
{
    while (std::abs(unstable - stable) > 1e-6 * std::min(stable, unstable)) {
        const double middle = std::sqrt(stable * unstable);
        (growth(middle) > 0.0 ? unstable : stable) = middle;
    }
    return stable;
}

/* The last value, from `from` by equal ratios to `to`, before the loop grows; a mode that is unstable in between
 * only may be passed over where it is narrower than the grid. */
std::optional<double> stable_up_to(double from, double to, int steps, const std::function<double(double)> &growth)
{
    if (growth(from) > 0.0) {
        return 0.0;
    }
    double stable = from;
    for (int i = 1; i <= steps; i++) {
        const double next = from * std::pow(to / from, static_cast<double>(i) / steps);
        if (growth(next) > 0.0) {
            return edge_between(stable, next, growth);
        }
        stable = next;
    }
    return {};
}

/* The same, and where it is stable again. */
std::vector<stable_range> stable_ranges(double from, double to, int steps,
                                        const std::function<double(double)> &growth)
{
    std::vector<stable_range> ranges;
    double last = from;
    bool was_stable = growth(from) <= 0.0;
    double begin = from;
    for (int i = 1; i <= steps; i++) {
        const double next = from * std::pow(to / from, static_cast<double>(i) / steps);
        const bool is_stable = growth(next) <= 0.0;
        if (was_stable && !is_stable) {
            ranges.push_back({begin, edge_between(last, next, growth)});
        } else if (is_stable && !was_stable) {
            begin = edge_between(next, last, growth);
        }
        was_stable = is_stable;
        last = next;
    }
    if (was_stable) {
        ranges.push_back({begin, to});
    }
    return ranges;
}

/* As stable_up_to. */
std::optional<double> limit_of(const std::vector<stable_range> &ranges, double from, double to)
{
    if (ranges.empty() || ranges.front().from > from) {
        return 0.0;
    }
    return ranges.front().to < to ? std::optional<double>(ranges.front().to) : std::nullopt;
}

loop_limits stiffest(const rig &rig, const growth_of_rig &reduced, const growth_of_rig &full)
{
    const auto largest = [&](const growth_of_rig &growth) {
        return stable_up_to(softer_min, stiffer_max, 80, [&](double factor) {
            berth::rig stiffer = rig;
            stiffer.object.stiffness_N_per_m *= factor;
            return growth(stiffer);
        });
    };
    return {largest(reduced), largest(full), softer_min, stiffer_max, {}, {}};
}

loop_limits dead_times(const rig &rig, const growth_of_rig &reduced, const growth_of_rig &full)
{
    const double own_ms = rig.robot.dead_time_ms;
    double least_ms = own_ms;
    for (std::size_t axis = 0; axis < rig.side_axes.size(); axis++) {
        if (rig.firmware.side_axes[axis].enabled != 0) {
            least_ms = std::min(least_ms, rig.side_axes[axis].dead_time_ms);
        }
    }
    /* A robot on straight lines is a period late at least. */
    const double period_ms = 1e3 * config_period_s(&rig.firmware);
    const double shortest_ms = std::max(own_ms - std::max(0.0, least_ms - period_ms), shorter_min * period_ms);
    const double looked_to_ms =
        std::min(longer_max * std::max(own_ms, period_ms), std::max(1.25 * own_ms, periods_max * period_ms));
    const auto ranges = [&](const growth_of_rig &growth) {
        return stable_ranges(shortest_ms, looked_to_ms, 24, [&](double dead_time_ms) {
            berth::rig late = rig;
            move_dead_time(late, dead_time_ms);
            return growth(late);
        });
    };
    const std::vector<stable_range> of_reduced = ranges(reduced);
    const std::vector<stable_range> of_full = ranges(full);
    return {limit_of(of_reduced, shortest_ms, looked_to_ms),
            limit_of(of_full, shortest_ms, looked_to_ms),
            shortest_ms,
            looked_to_ms,
            of_reduced,
            of_full};
}

} // namespace

reduction_choice choice_at_start(const rig &rig, const arm_config &arm)
{
    reduction_choice choice;
    choice.pose_rad.resize(arm.joint_count);
    for (Eigen::Index i = 0; i < arm.joint_count; i++) {
        choice.pose_rad(i) = arm.joints[i].initial_rad;
    }
    const manipulator_config &manipulator = rig.firmware.manipulator;
    choice.direction = Eigen::Vector3d(manipulator.direction_x, manipulator.direction_y, manipulator.direction_z)
                           .head(arm.kind == ARM_PLANAR ? 2 : 3);
    return choice;
}

std::optional<arm_mode> arm_at_start(const rig &rig)
{
    const arm_config &arm = rig.firmware.arm;
    if (arm.kind == ARM_NONE) {
        return {};
    }
    const reduction_choice choice = choice_at_start(rig, arm);
    const linear_arm whole = linearise(arm, choice.pose_rad);
    return dominant_mode(modes_along(whole, choice.direction, whole));
}

reduction reduce(const rig &rig, const arm_config &config, const reduction_choice &choice)
{
    const linear_arm whole = linearise(config, choice.pose_rad);
    const linear_arm arm = choice.is_guided ? guided(whole, choice.direction) : whole;
    reduction result = {};
    result.modes = modes_along(arm, choice.direction, whole);
    result.reduced = dominant_mode(result.modes);
    result.coupled_reduced = coupled_of(rig, result.reduced);
    result.visible = visible_modes(config, choice, object_modes(rig.object));
    if (const coupled_mode *nearest = nearest_mode(result.visible, result.coupled_reduced.frequency_Hz)) {
        result.nearest = *nearest;
        result.coupled_full = swing_of(nearest->s);
    }
    const double period_s = config_period_s(&rig.firmware);
    const auto full = [&](const berth::rig &at) {
        return growth_of(arm_loop_matrix(at, config, arm, choice.direction), period_s);
    };
    const auto reduced = [&](const berth::rig &at) {
        const spectrum found = loop_spectrum(with_reduced(at, result.reduced));
        return arm_loop_growth{found.spectral_radius, found.growth_per_s, found.modes.front().frequency_Hz};
    };
    result.loop_full = full(rig);
    result.loop_reduced = reduced(rig);
    const auto full_growth = [&](const berth::rig &at) { return full(at).growth_per_s; };
    const auto reduced_growth = [&](const berth::rig &at) {
        return std::log(spectral_radius_of(with_reduced(at, result.reduced)));
    };
    result.object_stiffness = stiffest(rig, reduced_growth, full_growth);
    result.dead_time_ms = dead_times(rig, reduced_growth, full_growth);
    return result;
}

object_reduction reduce_object(const rig &rig)
{
    object_reduction result = {};
    result.arm_at_start = arm_at_start(rig);
    const berth::rig full = result.arm_at_start ? with_reduced(rig, *result.arm_at_start) : rig;
    const auto with_one_mode = [](berth::rig at) {
        at.object.further_mode_count = 0;
        return at;
    };
    const berth::rig first = with_one_mode(full);
    result.modes = object_modes(full.object);
    double compliance_m_per_N = 0.0;
    for (const beam_mode &mode : result.modes) {
        compliance_m_per_N += 1.0 / mode.stiffness_N_per_m;
    }
    result.compliance_share = 1.0 / (result.modes.front().stiffness_N_per_m * compliance_m_per_N);
    const auto coupled = [&](const berth::rig &at) {
        const linear_arm both =
            with_object(arm_of(at.firmware.manipulator), Eigen::RowVectorXd::Ones(1), object_modes(at.object));
        const std::vector<std::complex<double>> found = eigenvalues_of(both); /* by rising size */
        const auto swings =
            std::find_if(found.begin(), found.end(), [](const std::complex<double> &s) { return s.imag() > 0.0; });
        return swings == found.end() ? swing{0.0, 1.0} : swing_of(*swings);
    };
    result.coupled_reduced = coupled(first);
    result.coupled_full = coupled(full);
    const auto in_loop = [](const berth::rig &at) {
        const spectrum found = loop_spectrum(at);
        return arm_loop_growth{found.spectral_radius, found.growth_per_s, found.modes.front().frequency_Hz};
    };
    result.loop_reduced = in_loop(first);
    result.loop_full = in_loop(full);
    const auto full_growth = [](const berth::rig &at) { return std::log(spectral_radius_of(at)); };
    const auto reduced_growth = [&](const berth::rig &at) { return full_growth(with_one_mode(at)); };
    result.object_stiffness = stiffest(full, reduced_growth, full_growth);
    result.dead_time_ms = dead_times(full, reduced_growth, full_growth);
    return result;
}

} // namespace berth
