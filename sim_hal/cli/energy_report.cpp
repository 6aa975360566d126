#include "energy_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

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
    const double at_end_J = last_.stored_J - last_.operator_J;
    /* Force and position that wander with noise swap some energy back and forth without making any. */
    const struct {
        std::size_t from;
        double noticeable;
    } spans[] = {{not_by_operator_J.size() / 2, 1e-2}, {0, 1e-6}};
    for (const auto &span : spans) {
        const double changed_J = at_end_J - not_by_operator_J[span.from];
        if (std::abs(changed_J) > span.noticeable * range_J) {
            return changed_J > 0.0;
        }
    }
    return {};
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
