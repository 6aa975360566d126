#include "energy_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace berth
{

void energy_report::note_tick(const tick_record &record)
{
    last_ = {record.energy_stored_J,     record.energy_operator_J,       record.energy_dissipated_J,
             record.energy_integrator_J, record.energy_simulated_port_J, record.energy_measured_port_J,
             record.energy_dead_time_J,  record.energy_compensation_J};
    not_by_operator_J_.add(last_.stored_J - last_.operator_J);
}

std::optional<bool> energy_report::gains() const
{
    const std::vector<double> &not_by_operator_J = not_by_operator_J_.values();
    if (not_by_operator_J.empty() || has_arm) {
        return {};
    }
    const auto [least, most] = std::minmax_element(not_by_operator_J.begin(), not_by_operator_J.end());
    const double range_J = *most - *least;
    const auto quarter = static_cast<std::ptrdiff_t>(not_by_operator_J.size() / 4);
    const auto mean_J = [&](std::ptrdiff_t from) {
        return std::accumulate(not_by_operator_J.begin() + from, not_by_operator_J.begin() + from + quarter, 0.0) /
               static_cast<double>(quarter);
    };
    /* Energy goes to and fro between manipulator and object, which does not show in the mean of a quarter of the
     * run. Force and position that wander with noise swap some of it without making any. */
    constexpr double noticeable = 1e-2;
    constexpr double noticeable_of_whole = 1e-6;
    if (const double changed_J = quarter > 0 ? mean_J(3 * quarter) - mean_J(quarter) : 0.0;
        std::abs(changed_J) > noticeable * range_J) {
        return changed_J > 0.0;
    }
    const double changed_J = last_.stored_J - last_.operator_J - not_by_operator_J.front();
    return std::abs(changed_J) > noticeable_of_whole * range_J ? std::optional(changed_J > 0.0) : std::nullopt;
}

void energy_report::print() const
{
    if (not_by_operator_J_.values().empty()) {
        return;
    }
    const auto has_gained = gains();
    const double rounding_J = 1e-12 * (last_.dissipated_J + std::abs(last_.measured_port_J));
    const auto told = [&](double energy_J) { return std::abs(energy_J) > rounding_J ? energy_J : 0.0; };
    std::printf("  %-14s %sdead time made %+.4g J", "energy",
                has_arm       ? ""
                : !has_gained ? "none: "
                : *has_gained ? "GAINED: "
                              : "lost: ",
                told(last_.dead_time_J));
    if (told(last_.compensation_J) != 0.0) {
        std::printf(", compensation %+.4g J", last_.compensation_J);
    }
    if (told(last_.integrator_J) != 0.0) {
        std::printf(", the manipulator's step %+.4g J", last_.integrator_J);
    }
    if (has_arm) {
        std::printf("; the arm's joints and satellite gave %.4g J, hardware took %.4g J\n", told(last_.operator_J),
                    told(last_.measured_port_J));
        return;
    }
    std::printf("; operator gave %.4g J, manipulator's damping took %.4g J, hardware %.4g J\n",
                told(last_.operator_J), last_.dissipated_J, told(last_.measured_port_J));
}

nlohmann::json energy_report::as_json() const
{
    nlohmann::json json = {{"gains", nullptr},
                           {"dead_time_J", last_.dead_time_J},
                           {"compensation_J", last_.compensation_J},
                           {"integrator_J", last_.integrator_J},
                           {"operator_J", last_.operator_J},
                           {"dissipated_J", last_.dissipated_J},
                           {"simulated_port_J", last_.simulated_port_J},
                           {"measured_port_J", last_.measured_port_J},
                           {"stored_J", last_.stored_J}};
    if (const auto has_gained = gains()) {
        json["gains"] = *has_gained;
    }
    return json;
}

} // namespace berth
