#include "accuracy.h"

#include <cmath>
#include <limits>

namespace berth
{

namespace
{

constexpr double tolerance = 1e-12;

/* A number that grows beyond all bounds compares false with everything on its way: it is made infinite. */
double worse(double worst, double error)
{
    return std::isfinite(error) ? std::max(worst, error) : std::numeric_limits<double>::infinity();
}

accuracy_row compare(const std::vector<berthing_sample> &stepped, const std::vector<berthing_sample> &truth)
{
    accuracy_row row = {};
    for (std::size_t i = 0; i < truth.size(); i++) {
        row.tool_m = worse(row.tool_m, (stepped[i].tool_m - truth[i].tool_m).norm());
        row.force_N = worse(row.force_N, (stepped[i].force_N - truth[i].force_N).norm());
        row.energy_J = worse(row.energy_J, std::abs(stepped[i].energy_J - truth[i].energy_J));
    }
    return row;
}

} // namespace

accuracy find_accuracy(const arm_config &arm, const berthing_plan &plan,
                       const std::function<void(double share)> &tell_progress)
{
    const berthing_truth truth = true_berthing(arm, plan, tolerance);
    accuracy result = {};
    result.truth_m = compare(true_berthing(arm, plan, 10.0 * tolerance).samples, truth.samples).tool_m;
    result.events = truth.events;
    for (const berthing_sample &sample : truth.samples) {
        result.force_N = std::max(result.force_N, sample.force_N.norm());
        result.energy_J = std::max(result.energy_J, sample.energy_J);
    }
    const std::array forces = {berthing_force::mean, berthing_force::held, berthing_force::led};
    const std::size_t count = forces.size() * ARM_INTEGRATOR_COUNT * accuracy_steps_ms.size();
    for (const berthing_force force : forces) {
        for (int i = 0; i < ARM_INTEGRATOR_COUNT; i++) {
            const auto integrator = static_cast<arm_integrator>(i);
            for (const double step_ms : accuracy_steps_ms) {
                accuracy_row row =
                    compare(stepped_berthing(arm, plan, integrator, 1e-3 * step_ms, force, truth), truth.samples);
                row.integrator = integrator;
                row.force = force;
                row.step_ms = step_ms;
                row.force_N = force == berthing_force::mean ? 0.0 : row.force_N;
                result.rows.push_back(row);
                tell_progress(static_cast<double>(result.rows.size()) / static_cast<double>(count));
            }
        }
    }
    for (int i = 0; i < ARM_INTEGRATOR_COUNT; i++) {
        result.drifts.push_back(stepped_momentum(arm, plan, static_cast<arm_integrator>(i), 2.5e-3));
    }
    return result;
}

} // namespace berth
