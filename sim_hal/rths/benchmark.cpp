#include "benchmark.h"

#include <cmath>

namespace berth::rths
{

namespace
{

using samples = std::vector<double>;

double mean(const samples &values)
{
    double sum = 0.0;
    for (const double value : values) {
        sum += value;
    }
    return sum / static_cast<double>(values.size());
}

double standard_deviation(const samples &values)
{
    const double middle = mean(values);
    double sum = 0.0;
    for (const double value : values) {
        sum += (value - middle) * (value - middle);
    }
    return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double peak(const samples &values)
{
    double largest = 0.0;
    for (const double value : values) {
        largest = std::max(largest, std::abs(value));
    }
    return largest;
}

samples difference(const samples &a, const samples &b)
{
    samples result(a.size());
    for (std::size_t n = 0; n < a.size(); n++) {
        result[n] = a[n] - b[n];
    }
    return result;
}

/* Pearson's coefficient of what comes `lag` samples behind. */
double correlation(const samples &behind, const samples &ahead, std::size_t lag)
{
    const std::size_t count = behind.size() - lag;
    double sum_b = 0.0;
    double sum_a = 0.0;
    double sum_bb = 0.0;
    double sum_aa = 0.0;
    double sum_ba = 0.0;
    for (std::size_t n = 0; n < count; n++) {
        const double b = behind[n + lag];
        const double a = ahead[n];
        sum_b += b;
        sum_a += a;
        sum_bb += b * b;
        sum_aa += a * a;
        sum_ba += b * a;
    }
    const auto size = static_cast<double>(count);
    return (sum_ba - sum_b * sum_a / size) /
           std::sqrt((sum_bb - sum_b * sum_b / size) * (sum_aa - sum_a * sum_a / size));
}

/* The benchmark looks at 0 to 49 whole samples: no lead, and nothing between two samples. */
double delay_ms(const samples &measured, const samples &simulated)
{
    constexpr std::size_t lags = 50;
    std::size_t best = 0;
    double highest = -2.0;
    for (std::size_t lag = 0; lag < lags && lag + 2 < measured.size(); lag++) {
        const double value = correlation(measured, simulated, lag);
        if (value > highest) {
            highest = value;
            best = lag;
        }
    }
    return 1e3 * period_s * static_cast<double>(best);
}

double spread_percent(const samples &is, const samples &should)
{
    return 100.0 * standard_deviation(difference(is, should)) / standard_deviation(should);
}

double peak_percent(const samples &is, const samples &should)
{
    return 100.0 * peak(difference(is, should)) / peak(should);
}

} // namespace

run_record run_benchmark(const building &all, const ground_motion &ground, const transfer_parameters &hardware,
                         controller &controller, const run_settings &settings)
{
    frame reference(all);
    frame simulated(all, hardware);
    transfer_system transfer(hardware, settings.seed, settings.noise_scale);
    run_record record;
    double late_N = 0.0;
    double given_N = 0.0;
    const auto samples_in_all = static_cast<std::int64_t>(ground.end_s() * rate_Hz) + 1;
    for (std::int64_t n = 0; n < samples_in_all; n++) {
        const double now_s = static_cast<double>(n) * period_s;
        const double ground_m_per_s2 = ground.at(now_s);
        const measurement measured = transfer.measure();
        const frame_state &state = simulated.state();
        const controller_output output = controller.step(
            {state(0), state(floors), simulated.first_floor_acceleration_m_per_s2(ground_m_per_s2, given_N), state,
             ground_m_per_s2, measured.position_m, late_N});
        record.command_m.push_back(output.command_m);
        record.measured_m.push_back(measured.position_m);
        record.measured_N.push_back(measured.force_N);
        record.true_m.push_back(transfer.state()(position));
        record.true_N.push_back(transfer.state()(force));
        for (int floor = 0; floor < floors; floor++) {
            record.simulated_m[static_cast<std::size_t>(floor)].push_back(state(floor));
            record.reference_m[static_cast<std::size_t>(floor)].push_back(reference.state()(floor));
        }
        given_N = output.force_N;
        late_N = measured.force_N;
        transfer.step(output.command_m);
        simulated.step(now_s, ground, given_N);
        reference.step(now_s, ground, 0.0);
    }
    return record;
}

criteria judge(const run_record &record)
{
    const samples &measured = record.measured_m;
    const auto &simulated = record.simulated_m;
    const auto &reference = record.reference_m;
    return {delay_ms(measured, simulated[0]),           spread_percent(measured, simulated[0]),
            peak_percent(measured, simulated[0]),       spread_percent(measured, reference[0]),
            peak_percent(measured, reference[0]),       spread_percent(simulated[1], reference[1]),
            spread_percent(simulated[2], reference[2]), peak_percent(simulated[1], reference[1]),
            peak_percent(simulated[2], reference[2])};
}

noise_share noise_alone(const run_record &record)
{
    const samples noise = difference(record.measured_m, record.true_m);
    return {100.0 * standard_deviation(noise) / standard_deviation(record.simulated_m[0]),
            100.0 * peak(noise) / peak(record.simulated_m[0])};
}

} // namespace berth::rths
