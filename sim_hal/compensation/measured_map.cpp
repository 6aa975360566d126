#include "measured_map.h"

#include <cmath>
#include <limits>

#include "../stability/shared_rows.h"

namespace berth
{

namespace
{

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double usual_amplitude_m = 0.01;

measured_point worst_at(map_point_setter &setter, double duration_s)
{
    measured_point worst{-std::numeric_limits<double>::infinity(), 0.0, fate::decays};
    setter.for_each_model([&](const rig &told) {
        const measured_point one = measure(told, duration_s);
        worst = {std::max(worst.growth_per_s, one.growth_per_s), std::max(worst.error, one.error),
                 std::max(worst.fate, one.fate),
                 one.growth_per_s > worst.growth_per_s ? one.is_faulted : worst.is_faulted};
    });
    return worst;
}

} // namespace

double rest_m(const rig &rig)
{
    return rig.firmware.operator_command.interface == OPERATOR_INTERFACE_MOTION ? rig.profile.offset_m : 0.0;
}

rig released_rig(const rig &rig, double amplitude_m)
{
    berth::rig released = rig;
    const double place_m = rest_m(rig);
    manipulator_config &arm = released.firmware.manipulator;
    released.profile.kind = profile_kind::rest;
    if (amplitude_m > 0.0) {
        arm.initial_position_m = place_m + amplitude_m;
        arm.initial_velocity_m_per_s = 0.0;
    } else if (arm.initial_position_m == place_m && arm.initial_velocity_m_per_s == 0.0) {
        arm.initial_position_m = place_m + usual_amplitude_m;
    }
    return released;
}

measured_point measure(const rig &rig, double duration_s)
{
    const trial_result trial = run_trial(rig, duration_s);
    return {trial.growth_per_s, trial.error, trial.fate, !trial.has_growth};
}

std::vector<measured_point> compute_measured_map(const map_request &request, double duration_s, int threads,
                                                 const std::function<void(int)> &rows_done)
{
    std::vector<measured_point> points(request.points(), {nan, nan, fate::diverges});
    share_rows(request.y.count, threads, rows_done, [&] {
        return [&, setter = map_point_setter(request)](int row) mutable {
            measured_point *const of_row =
                &points[static_cast<std::size_t>(row) * static_cast<std::size_t>(request.x.count)];
            for (int i = 0; i < request.x.count; i++) {
                if (setter.set(request.x.value(i), request.y.value(row)) == point_state::possible) {
                    of_row[i] = worst_at(setter, duration_s);
                }
            }
        };
    });
    return points;
}

} // namespace berth
