#include "varying_map.h"

#include <algorithm>
#include <limits>
#include <string_view>

#include "equivalent_loop.h"
#include "lyapunov.h"
#include "shared_rows.h"

namespace berth
{

namespace
{

/* Whether the values along an axis leave the timing of the loop alone. */
bool keeps_timing(const map_axis &axis)
{
    constexpr std::string_view without_time[] = {
        frequency_ratio_axis, damping_ratio_axis, "manipulator.",    "object.",        "sensor.stiffness_",
        "sensor.damping_",    "sensor.low_pass_", "robot.transfer_", "inverse_filter."};
    for (const std::string_view start : without_time) {
        if (std::string_view(axis.name).substr(0, start.size()) == start) {
            return true;
        }
    }
    return false;
}

} // namespace

std::vector<double> compute_varying_map(const map_request &request, const wake_histogram &histogram,
                                        std::int64_t ticks, int threads, const std::function<void(int)> &rows_done)
{
    std::vector<double> exponents(request.points(), std::numeric_limits<double>::quiet_NaN());
    const bool has_one_timeline = keeps_timing(request.x) && keeps_timing(request.y) && request.amplitude_m == 0.0 &&
                                  !has_schedule(request.rig);
    const loop_timeline common = has_one_timeline ? make_timeline(request.rig, histogram, ticks) : loop_timeline{};
    const auto linear_rig = [&](const rig &at) { /* each point anew, as in a map without what varies */
                                                 return request.amplitude_m > 0.0
                                                            ? equivalent_finder(request.amplitude_m).find(at).linear
                                                            : at;
    };
    share_rows(request.y.count, threads, rows_done, [&] {
        return [&, setter = map_point_setter(request), finder = exponent_finder()](int row) mutable {
            const auto growth_of = [&](const rig &at) {
                return has_one_timeline ? finder.along(at, common).growth_per_s
                                        : finder.along(at, make_timeline(at, histogram, ticks)).growth_per_s;
            };
            double *const values =
                &exponents[static_cast<std::size_t>(row) * static_cast<std::size_t>(request.x.count)];
            for (int i = 0; i < request.x.count; i++) {
                const bool is_possible =
                    setter.set(request.x.value(i), request.y.value(row)) == point_state::possible &&
                    fits_period(histogram, setter.rig());
                if (is_possible) {
                    double worst_per_s = -std::numeric_limits<double>::infinity();
                    setter.for_each_loop(
                        [&](const rig &loop) { worst_per_s = std::max(worst_per_s, growth_of(linear_rig(loop))); });
                    values[i] = worst_per_s;
                }
            }
        };
    });
    return exponents;
}

} // namespace berth
