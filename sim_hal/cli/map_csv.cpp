#include "map_csv.h"

#include <charconv>
#include <cmath>
#include <string>

#include "map_request.h"

namespace berth
{

namespace
{

void append(std::string &line, double value, char end)
{
    char digits[32];
    const char *const last = std::to_chars(digits, digits + sizeof digits, value).ptr;
    if (std::isnan(value)) { /* without a sign, which would be chance */
        line += "nan";
    } else {
        line.append(digits, static_cast<std::size_t>(last - digits));
    }
    line += end;
}

void append_measured(std::string &line, const measured_point &point)
{
    append(line, point.error, ',');
    append(line, std::isnan(point.error) ? point.error : point.fate == fate::lasts ? 1.0 : 0.0, ',');
    append(line, std::isnan(point.error) ? point.error : point.is_faulted ? 1.0 : 0.0, ',');
}

/* Share of the way between two neighbours on which the growth is negative, as far as a straight line tells. */
double stable_share(double growth_per_s, double next_per_s)
{
    const double low = std::min(growth_per_s, next_per_s);
    const double high = std::max(growth_per_s, next_per_s);
    return !(low < 0.0) ? 0.0 : high < 0.0 ? 1.0 : high >= 0.0 ? low / (low - high) : 0.0;
}

} // namespace

map_summary write_csv(const map_request &request, const map_values &map,
                      const std::function<void(std::string_view)> &write)
{
    map_summary sums;
    const bool varies = !map.exponents.empty();
    write(request.x.name + "," + request.y.name + ",spectral_radius,growth_per_s,wall" +
          (map.lower_end ? ",spectral_radius_low" : "") + (map.reduced ? ",spectral_radius_reduced" : "") +
          (varies ? ",lyapunov_per_s" : "") + (map.measured.empty() ? "" : ",fidelity_error,lasts,faulted") +
          (map.restitution.empty() ? "" : ",restitution") + "\n");
    std::string lines;
    map_point_setter setter(request);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    std::size_t point = 0;
    for (int row = 0; row < request.y.count; row++) {
        const double y = request.y.value(row);
        double growth_before_per_s = nan;
        lines.clear();
        for (int i = 0; i < request.x.count; i++, point++) {
            const double x = request.x.value(i);
            const double radius = map.steady.spectral_radius[point];
            const point_state state = setter.set(x, y);
            const bool is_possible = state == point_state::possible && !std::isnan(radius);
            const bool is_below = is_possible && coupled_damped_frequency_Hz(setter.rig()) < wall_Hz;
            const double growth_per_s =
                is_possible ? std::log(radius) / config_period_s(&setter.rig().firmware) : nan;
            if (is_possible) {
                const bool gains_by_bounces = !map.restitution.empty() && map.restitution[point] > 1.0;
                const bool is_stable = map.measured.empty()
                                           ? radius < 1.0 && !gains_by_bounces &&
                                                 !(request.amplitude_m == 0.0 && drifts_freely(setter.rig()))
                                           : map.measured[point].fate == fate::decays;
                sums.steady.add(radius, is_stable, is_below);
            } else {
                (state == point_state::not_passive ? sums.not_passive : sums.invalid)++;
            }
            append(lines, x, ',');
            append(lines, y, ',');
            append(lines, radius, ',');
            append(lines, growth_per_s, ',');
            append(lines, !is_possible ? nan : is_below ? 1.0 : 0.0, ',');
            if (map.lower_end) {
                const double lower = map.lower_end->spectral_radius[point];
                append(lines, lower, ',');
                if (!std::isnan(lower)) {
                    sums.lower_end.add(lower,
                                       lower < 1.0 && !(request.amplitude_m == 0.0 && drifts_freely(setter.rig())),
                                       is_below);
                }
            }
            if (map.reduced) {
                const double reduced = map.reduced->spectral_radius[point];
                append(lines, reduced, ',');
                if (is_possible && !std::isnan(reduced)) {
                    sums.misled.add(radius, reduced);
                }
            }
            if (varies) {
                const double exponent_per_s = map.exponents[point];
                append(lines, exponent_per_s, ',');
                if (is_possible) {
                    sums.varying.add(exponent_per_s, exponent_per_s < 0.0, is_below);
                }
                if (is_possible && i > 0) {
                    sums.stable_intervals += stable_share(growth_before_per_s, growth_per_s);
                    sums.stable_intervals_varying += stable_share(map.exponents[point - 1], exponent_per_s);
                }
            }
            if (!map.measured.empty()) {
                append_measured(lines, map.measured[point]);
                if (is_possible) {
                    sums.measured.add(map.measured[point], is_below);
                }
            }
            if (!map.restitution.empty()) {
                append(lines, map.restitution[point], ',');
                if (!std::isnan(map.restitution[point])) {
                    sums.bounces.add(map.restitution[point]);
                }
            }
            lines.back() = '\n';
            growth_before_per_s = growth_per_s;
        }
        write(lines);
    }
    return sums;
}

} // namespace berth
