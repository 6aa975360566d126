#include "accuracy.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace berth
{

namespace
{

constexpr double truth_tolerance = 1e-12;

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

/* What all rows of an arm have in common. */
struct subject {
    const arm_config &arm;
    const berthing_plan &plan;
    const berthing_truth &truth;

    accuracy_row row(arm_integrator integrator, berthing_force force, double step_ms, std::int64_t substeps) const
    {
        const fixed_step step = {1e-3 * step_ms, substeps};
        accuracy_row found = compare(stepped_berthing(arm, plan, integrator, step, force, truth), truth.samples);
        found.integrator = integrator;
        found.force = force;
        found.step_ms = step_ms;
        found.substeps = substeps;
        found.force_N = force == berthing_force::mean ? 0.0 : found.force_N;
        return found;
    }
};

constexpr std::array forces = {berthing_force::mean, berthing_force::held, berthing_force::led};

/* Up to 8 one by one, then each a quarter more than the one before, as long as more of them make it better: what
 * comes of a force that is the same over the step stays. */
std::optional<accuracy_row> enough_substeps(const subject &of, const accuracy_question &question, double own_m)
{
    constexpr std::int64_t substeps_max = 64;
    constexpr double hardly_better = 0.98;
    const auto integrator = static_cast<arm_integrator>(of.arm.integrator);
    double last_m = own_m;
    for (std::int64_t substeps = of.arm.substeps + 1; substeps <= substeps_max;
         substeps += std::max<std::int64_t>(1, substeps / 4)) {
        const accuracy_row row = of.row(integrator, berthing_force::mean, question.step_ms, substeps);
        if (row.tool_m <= question.tool_max_m) {
            return row;
        }
        if (row.tool_m > hardly_better * last_m) {
            return {};
        }
        last_m = row.tool_m;
    }
    return {};
}

} // namespace

const accuracy_row &row_at(const accuracy &found, arm_integrator integrator, berthing_force force, double step_ms,
                           std::int64_t substeps)
{
    return *std::find_if(found.rows.begin(), found.rows.end(), [&](const accuracy_row &row) {
        return row.integrator == integrator && row.force == force && row.step_ms == step_ms &&
               row.substeps == substeps;
    });
}

accuracy find_accuracy(const arm_config &arm, const berthing_plan &plan, const accuracy_question &question,
                       const std::function<void(double share)> &tell_progress)
{
    const berthing_truth truth = true_berthing(arm, plan, truth_tolerance);
    accuracy result = {};
    result.truth_m = compare(true_berthing(arm, plan, 10.0 * truth_tolerance).samples, truth.samples).tool_m;
    result.events = truth.events;
    for (const berthing_sample &sample : truth.samples) {
        result.force_N = std::max(result.force_N, sample.force_N.norm());
        result.energy_J = std::max(result.energy_J, sample.energy_J);
    }
    const subject of = {arm, plan, truth};
    const std::size_t steps = accuracy_steps_ms.size() + (arm.substeps > 1 ? 1 : 0);
    const std::size_t count = forces.size() * ARM_INTEGRATOR_COUNT * steps;
    const auto add = [&](berthing_force force, int integrator, double step_ms, std::int64_t substeps) {
        result.rows.push_back(of.row(static_cast<arm_integrator>(integrator), force, step_ms, substeps));
        tell_progress(static_cast<double>(result.rows.size()) / static_cast<double>(count));
    };
    for (const berthing_force force : forces) {
        for (int i = 0; i < ARM_INTEGRATOR_COUNT; i++) {
            for (const double step_ms : accuracy_steps_ms) {
                add(force, i, step_ms, 1);
            }
            if (arm.substeps > 1) {
                add(force, i, question.step_ms, arm.substeps);
            }
        }
    }
    for (int i = 0; i < ARM_INTEGRATOR_COUNT && arm.base_is_free != 0; i++) {
        result.drifts.push_back(
            stepped_momentum(arm, plan, static_cast<arm_integrator>(i), {1e-3 * question.step_ms, arm.substeps}));
    }
    const accuracy_row &own = row_at(result, static_cast<arm_integrator>(arm.integrator), berthing_force::mean,
                                     question.step_ms, arm.substeps);
    if (!(own.tool_m <= question.tool_max_m)) {
        result.enough = enough_substeps(of, question, own.tool_m);
    }
    return result;
}

} // namespace berth
