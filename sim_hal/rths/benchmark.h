/* A run of the benchmark, and its nine criteria. */
#ifndef SIM_HAL_RTHS_BENCHMARK_H
#define SIM_HAL_RTHS_BENCHMARK_H

#include <array>
#include <vector>

#include "controller.h"

namespace berth::rths
{

/* Every sample of a run. */
struct run_record {
    std::vector<double> command_m;
    std::vector<double> measured_m;
    std::vector<double> true_m;
    std::vector<double> force_N;
    std::array<std::vector<double>, floors> simulated_m;
    std::array<std::vector<double>, floors> reference_m;
};

struct run_settings {
    std::int64_t seed = 1;    /* of the sensors' noise */
    double noise_scale = 1.0; /* 0: none, and ideal converters */
};

run_record run_benchmark(const building &all, const ground_motion &ground, const transfer_parameters &hardware,
                         controller &controller, const run_settings &settings);

/* J1 in ms, J2 to J9 in percent. */
constexpr int criteria_count = 9;
using criteria = std::array<double, criteria_count>;
criteria judge(const run_record &record);

/* What J2 would be if the hardware did exactly what is simulated: the sensor's noise alone. */
double noise_floor_percent(const run_record &record);

} // namespace berth::rths

#endif
