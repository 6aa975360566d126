#include "events.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

constexpr std::size_t count_min = 5; /* fewer may be anything */

event_finding finding(const char *name, std::size_t count, std::size_t of)
{
    const double p = static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(of, 1));
    const double width = 1.96 * std::sqrt(p * (1.0 - p) / static_cast<double>(std::max<std::size_t>(of, 1)));
    return {find_effect(name), {p}, {width}, count};
}

/* Rows whose value is that of the row before, in runs of at most `run_max` between changes; none where that is so by
 * chance: where steps of one smallest change are as frequent. */
std::vector<std::uint8_t> repeated_rows(const record &record, const std::vector<double> &x)
{
    constexpr std::size_t run_max = 20;
    std::vector<std::uint8_t> rows(record.size(), 0);
    double smallest = unlimited;
    for (std::size_t n = 1; n < x.size(); n++) {
        const double change = std::abs(x[n] - x[n - 1]);
        if (change > 0.0) {
            smallest = std::min(smallest, change);
        }
    }
    std::size_t repeats = 0;
    std::size_t smallest_steps = 0;
    for (const record_segment &part : record.segments) {
        for (std::size_t n = part.begin + 1; n < part.end;) {
            if (x[n] != x[n - 1]) {
                smallest_steps += std::abs(x[n] - x[n - 1]) < 1.5 * smallest;
                n++;
                continue;
            }
            std::size_t end = n;
            while (end < part.end && x[end] == x[n - 1]) {
                end++;
            }
            if (end - n <= run_max && n > part.begin + 1 && end < part.end) {
                std::fill(rows.begin() + static_cast<std::ptrdiff_t>(n),
                          rows.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{1});
                repeats += end - n;
            }
            n = end;
        }
    }
    const double by_chance = 0.5 * static_cast<double>(smallest_steps) + 1.0;
    if (repeats < count_min || static_cast<double>(repeats) < 10.0 * by_chance) {
        return {};
    }
    return rows;
}

std::size_t count_of(const std::vector<std::uint8_t> &rows)
{
    return static_cast<std::size_t>(std::count(rows.begin(), rows.end(), std::uint8_t{1}));
}

double median(std::vector<double> values)
{
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace

std::vector<event_finding> find_repeats(const record &record, const rig &given, sample_events &events)
{
    std::vector<event_finding> found;
    if (!record.robot_position_m.empty()) {
        events.robot_repeats = repeated_rows(record, record.robot_position_m);
    }
    if (!record.force_N.empty()) {
        events.force_repeats = repeated_rows(record, record.force_N);
    }
    const std::size_t robot = count_of(events.robot_repeats);
    const std::size_t force = count_of(events.force_repeats);
    std::size_t both = 0;
    for (std::size_t n = 0; robot > 0 && force > 0 && n < record.size(); n++) {
        both += events.robot_repeats[n] != 0 && events.force_repeats[n] != 0;
    }
    if (both >= count_min && 10 * both >= 7 * std::max(robot, force)) {
        found.push_back(finding("loop.lost_samples", both, record.size()));
    } else if (force > 0 && given.sensor.loss_probability == 0.0 && given.sensor.stale_probability == 0.0 &&
               given.bus.loss_probability == 0.0) {
        found.push_back(finding("sensor.dropouts", force, record.size()));
    }
    return found;
}

/* The step that all values are whole numbers of, or 0. */
double lattice_step(const std::vector<double> &x)
{
    double step = unlimited;
    for (std::size_t n = 1; n < x.size(); n++) {
        const double change = std::abs(x[n] - x[n - 1]);
        if (change > 0.0) {
            step = std::min(step, change);
        }
    }
    std::size_t odd = 0;
    for (std::size_t n = 1; n < x.size(); n++) {
        const double steps = std::abs(x[n] - x[n - 1]) / step;
        odd += std::abs(steps - std::round(steps)) > 0.01 + 1e-4 * steps;
    }
    return step < unlimited && odd * 100 <= x.size() ? step : 0.0;
}

std::vector<event_finding> find_quantisation(const record &record, const rig &given, double noise_rms)
{
    const double step = lattice_step(record.force_N);
    /* q^2/12 is the variance of rounding; it has to be a good part of all that is not explained. */
    const double rounding = step / std::sqrt(12.0);
    if (step == 0.0 || given.sensor.resolution_N > 0.5 * step || rounding * rounding < 0.3 * noise_rms * noise_rms) {
        return {};
    }
    return {{find_effect("sensor.quantisation"), {step}, {1e-3 * step}, record.size()}};
}

std::vector<event_finding> find_spikes(const block_model &model, const std::vector<double> &error,
                                       sample_events &events)
{
    constexpr double far = 7.0; /* standard deviations; of 24000 normal ones none lies beyond 5 */
    std::vector<double> sizes;
    std::vector<double> off(error.size(), 0.0);
    for (std::size_t n = 2; n + 2 < error.size(); n++) {
        if (model.uses()[n - 1] == row_use::none || model.uses()[n] == row_use::none ||
            model.uses()[n + 1] == row_use::none) {
            continue;
        }
        off[n] = error[n] - 0.5 * (error[n - 1] + error[n + 1]);
        sizes.push_back(std::abs(off[n]));
    }
    const double sigma = 1.4826 * median(sizes);
    const double far_N = std::max(far * sigma, 2.0 * lattice_step(model.data().force_N));
    std::vector<std::uint8_t> rows(error.size(), 0);
    std::vector<double> amplitudes;
    for (std::size_t n = 2; n + 2 < error.size(); n++) {
        /* The sample itself, not its neighbours, which see half of it; and not a step, which has a second half. */
        const auto is_half = [&](double neighbour) { return std::abs(neighbour / off[n] + 0.5) < 0.25; };
        const bool is_single = is_half(off[n - 1]) && is_half(off[n + 1]);
        if (std::abs(off[n]) > far_N && is_single) {
            rows[n] = 1;
            amplitudes.push_back(std::abs(off[n]));
        }
    }
    if (amplitudes.size() < count_min || amplitudes.size() * 10 > sizes.size()) {
        return {};
    }
    events.spike = rows;
    event_finding found = finding("sensor.spikes", amplitudes.size(), sizes.size());
    double mean = 0.0;
    for (const double amplitude : amplitudes) {
        mean += amplitude / static_cast<double>(amplitudes.size());
    }
    double square = 0.0;
    for (const double amplitude : amplitudes) {
        square += (amplitude - mean) * (amplitude - mean);
    }
    const double count = static_cast<double>(amplitudes.size());
    found.values.push_back(mean);
    found.ci95.push_back(1.96 * std::sqrt((square / count + sigma * sigma) / count));
    return {found};
}

std::vector<event_finding> find_lost_commands(const block_model &model, const rig &rig,
                                              const std::vector<double> &error, sample_events &events)
{
    const record &record = model.data();
    const double ticks = 1e-3 * rig.robot.dead_time_ms / record.period_s;
    const auto whole = static_cast<std::size_t>(ticks + 1e-6);
    const double rest = std::max(0.0, ticks - static_cast<double>(whole));
    std::vector<double> sizes;
    for (std::size_t n = 0; n < error.size(); n++) {
        if (model.uses()[n] != row_use::none) {
            sizes.push_back(std::abs(error[n]));
        }
    }
    const double sigma = 1.4826 * median(sizes);
    std::vector<std::uint8_t> rows(error.size(), 0);
    /* How much of the loss of this setpoint the error looks like, and what of the error that leaves. */
    struct match {
        std::size_t row;
        double share;
        double left;
    };
    std::vector<match> matches;
    for (std::size_t n = 1; n + whole + 2 < record.size(); n++) {
        const std::size_t m = n + whole;
        if (model.uses()[m] == row_use::none || model.uses()[m + 1] == row_use::none) {
            continue;
        }
        /* The robot lacks (1 - f) of the way at this tick and f of it at the next one. */
        const double way = record.command_position_m[n] - record.command_position_m[n - 1];
        const double first = -(1.0 - rest) * way;
        const double second = -rest * way;
        const double size = std::hypot(first, second);
        if (size > 6.0 * sigma) {
            matches.push_back({n, (first * error[m] + second * error[m + 1]) / (size * size),
                               std::hypot(error[m] - first, error[m + 1] - second) / size});
        }
    }
    const std::size_t testable = matches.size();
    std::size_t hits = 0;
    std::size_t counter_hits = 0;
    for (std::size_t i = 0; i < testable; i++) {
        /* A wrong dead time looks like a little of a loss at every setpoint: against the neighbours, then. */
        const std::size_t begin = i < 8 ? 0 : i - 8;
        std::vector<double> near;
        for (std::size_t k = begin; k < std::min(testable, i + 9); k++) {
            near.push_back(matches[k].share);
        }
        const double share = matches[i].share - median(near);
        if (std::abs(share - 1.0) < 0.35 && matches[i].left < 0.5) {
            rows[matches[i].row] = 1;
            hits++;
        } else if (std::abs(share + 1.0) < 0.35) {
            counter_hits++;
        }
    }
    if (hits < count_min || counter_hits * 5 > hits || hits * 4 > testable) {
        return {};
    }
    events.lost_command = rows;
    return {finding("robot.lost_commands", hits, testable)};
}

} // namespace berth
