#include "map_report.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "../stability/lyapunov.h"

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
/* Share of the way between two neighbours on which the growth is negative, as far as a straight line tells. */
double stable_share(double growth_per_s, double next_per_s)
{
    const double low = std::min(growth_per_s, next_per_s);
    const double high = std::max(growth_per_s, next_per_s);
    return !(low < 0.0) ? 0.0 : high < 0.0 ? 1.0 : high >= 0.0 ? low / (low - high) : 0.0;
}
/* Negative: gained. */
double lost_share(const map_summary &sums)
{
    return sums.stable_intervals > 0.0 ? 1.0 - sums.stable_intervals_varying / sums.stable_intervals : 0.0;
}
nlohmann::json axis_json(const map_axis &axis)
{
    return {{"name", axis.name}, {"from", axis.from}, {"to", axis.to}, {"count", axis.count}};
}

double value_of(const rig &rig, const std::string &name)
{
    if (const rig_key *const key = find_key(name)) {
        void *const member = key->member(const_cast<berth::rig &>(rig));
        return key->type == key_type::integer ? static_cast<double>(*static_cast<std::int64_t *>(member))
                                              : *static_cast<double *>(member);
    }
    const map_point point = map_point_of(rig);
    return name == frequency_ratio_axis ? point.frequency_ratio : point.damping_ratio;
}

} // namespace

map_summary write_csv(const map_request &request, const map_values &map,
                      const std::function<void(std::string_view)> &write)
{
    map_summary sums;
    const bool varies = !map.exponents.empty();
    write(request.x.name + "," + request.y.name + ",spectral_radius,growth_per_s,wall" +
          (varies ? ",lyapunov_per_s\n" : "\n"));
    std::string lines;
    map_point_setter setter(request);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const double *value = map.steady.spectral_radius.data();
    const double *exponent = map.exponents.data();
    for (int row = 0; row < request.y.count; row++) {
        const double y = request.y.value(row);
        double growth_before_per_s = nan;
        lines.clear();
        for (int i = 0; i < request.x.count; i++) {
            const double x = request.x.value(i);
            const double radius = *value++;
            const point_state state = setter.set(x, y);
            double growth_per_s = nan;
            double wall = nan;
            if (state == point_state::possible) {
                const bool is_below = coupled_damped_frequency_Hz(setter.rig()) < wall_Hz;
                wall = is_below ? 1.0 : 0.0;
                growth_per_s = std::log(radius) / config_period_s(&setter.rig().firmware);
                sums.possible++;
                sums.below_wall += is_below;
                sums.stable += radius < 1.0;
                sums.stable_below_wall += is_below && radius < 1.0;
                sums.least = std::min(sums.least, radius);
                sums.largest = std::max(sums.largest, radius);
                if (varies) {
                    const bool is_stable = *exponent < 0.0;
                    sums.stable_varying += is_stable;
                    sums.stable_varying_below_wall += is_below && is_stable;
                    if (i > 0) {
                        sums.stable_intervals += stable_share(growth_before_per_s, growth_per_s);
                        sums.stable_intervals_varying += stable_share(exponent[-1], *exponent);
                    }
                }
            } else {
                (state == point_state::invalid ? sums.invalid : sums.not_passive)++;
            }
            append(lines, x, ',');
            append(lines, y, ',');
            append(lines, radius, ',');
            append(lines, growth_per_s, ',');
            growth_before_per_s = growth_per_s;
            append(lines, wall, varies ? ',' : '\n');
            if (varies) {
                append(lines, *exponent++, '\n');
            }
        }
        write(lines);
    }
    return sums;
}
nlohmann::json as_json(const map_job &job, const map_summary &sums)
{
    const map_request &request = job.request;
    const spectrum own = loop_spectrum(request.rig);
    const manipulator_config &arm = request.rig.firmware.manipulator;
    const double arm_Hz = std::sqrt(arm.stiffness_N_per_m / arm.mass_kg) / 6.28318530717958647692;
    const auto share = [](std::size_t part, std::size_t of) {
        return of > 0 ? nlohmann::json(static_cast<double>(part) / static_cast<double>(of)) : nlohmann::json();
    };
    const bool has_points = sums.possible > 0;
    nlohmann::json json = {{"rig", request.rig.name},
                           {"vary", request.kind == map_kind::mass         ? nlohmann::json("mass")
                                    : request.kind == map_kind::elasticity ? nlohmann::json("elasticity")
                                                                           : nlohmann::json()},
                           {"axes", {{"x", axis_json(request.x)}, {"y", axis_json(request.y)}}},
                           {"points", request.points()},
                           {"points_possible", sums.possible},
                           {"points_not_passive", sums.not_passive},
                           {"points_invalid", sums.invalid},
                           {"stable_share", share(sums.stable, sums.possible)},
                           {"stable_share_below_wall", share(sums.stable_below_wall, sums.below_wall)},
                           {"wall_Hz", wall_Hz},
                           {"manipulator_Hz", arm_Hz},
                           {"spectral_radius_min", has_points ? nlohmann::json(sums.least) : nlohmann::json()},
                           {"spectral_radius_max", has_points ? nlohmann::json(sums.largest) : nlohmann::json()},
                           {"own",
                            {{"x", value_of(request.rig, request.x.name)},
                             {"y", value_of(request.rig, request.y.name)},
                             {"spectral_radius", own.spectral_radius},
                             {"growth_per_s", own.growth_per_s},
                             {"stable", own.is_stable}}}};
    if (job.varying) {
        const rig &rig = job.varying->rig;
        const lyapunov_exponent exponent = exponent_of(rig, job.histogram);
        json["varying"] = {{"varies", what_varies(rig, job.histogram)},
                           {"ticks", job.ticks},
                           {"seed", rig.run.seed},
                           {"stable_share", share(sums.stable_varying, sums.possible)},
                           {"stable_share_below_wall", share(sums.stable_varying_below_wall, sums.below_wall)},
                           {"lost_share_of_stable_area", lost_share(sums)},
                           {"own_growth_per_s", exponent.growth_per_s},
                           {"own_growth_ci95_per_s", exponent.ci95_per_s}};
    }
    return json;
}
void print_map_summary(const map_request &request, const map_summary &sums, const nlohmann::json &json)
{
    const auto percent = [](std::size_t part, std::size_t of) {
        return of > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(of) : 0.0;
    };
    std::printf("%s: %s from %g to %g, %s from %g to %g\n", request.rig.name.c_str(), axis_title(request.x).c_str(),
                request.x.from, request.x.to, axis_title(request.y).c_str(), request.y.from, request.y.to);
    std::printf("  %zu points, %.1f %% of the possible stable, %.1f %% of those below the %g Hz wall\n",
                request.points(), percent(sums.stable, sums.possible),
                percent(sums.stable_below_wall, sums.below_wall), wall_Hz);
    if (json.contains("varying")) {
        for (const nlohmann::json &effect : json["varying"]["varies"]) {
            std::printf("  %s:\n", effect.get<std::string>().c_str());
        }
        const double lost = 100.0 * lost_share(sums);
        std::printf("    %.1f %% stable, %.1f %% of those below the wall; %.2f %% of the stable area %s\n",
                    percent(sums.stable_varying, sums.possible),
                    percent(sums.stable_varying_below_wall, sums.below_wall), std::abs(lost),
                    lost >= 0.0 ? "lost" : "gained");
    }
    if (sums.not_passive > 0) {
        std::printf("  %zu points left out (nan): they need a negative stiffness, damping or mass of the object\n",
                    sums.not_passive);
    }
    if (sums.invalid > 0) {
        std::printf("  %zu points left out (nan): there the rig is not valid\n", sums.invalid);
    }
    if (sums.possible > 0) {
        std::printf("  largest |z| from %.9f to %.9f\n", sums.least, sums.largest);
    }
    std::printf("  the rig itself: %s = %g, %s = %g, largest |z| %.9f\n", axis_title(request.x).c_str(),
                json["own"]["x"].get<double>(), axis_title(request.y).c_str(), json["own"]["y"].get<double>(),
                json["own"]["spectral_radius"].get<double>());
    std::printf("  %.3f s for the map\n", json["compute_s"].get<double>());
}

} // namespace berth
