/* A run of the benchmark, and its nine criteria.
 *
 * What its description leaves open was settled by what gives the recomputed rows, and by the benchmark's own
 * programs where they are public:
 * - In a sample: the sensors are read, the controller sees the simulated floor and the measured displacement of this
 *   sample and commands at once; command and force are held while both sides integrate. The frame gets the force
 *   measured at the sample before.
 * - The earthquake is linear between its samples, also at the stages within a step.
 * - The PI controller is 2 + 95/s on (lead of the target) - measured; lead and PI are made discrete by Tustin's
 * rule, one by one.
 * - The third-order inverse is that of the actuator moving next to nothing, not of the actuator with the specimen:
 *   with the specimen, J1 would be 0.24 ms and J2 2.5 %.
 * - The converters clip and round displacement and command. The force has no converter: 3.8 N would be none.
 * - 8900 N limit the state of the actuator's force. El Centro, Morgan and the nominal plant never come near; a stiff
 *   plant under Kobe in case 3 does.
 * - A perturbed specimen is taken out of the frame as it is: frame and hardware together are the reference
 * structure.
 * - J1 is the lag in whole samples, 0 to 49, of the largest correlation. Standard deviations are those of samples.
 * - J2's floor is the sensor's noise over the simulated motion: 2.09 % where the PI controller makes the frame move
 * a fifth more than the earthquake does, 2.56 % where it moves as it should (case 1, El Centro). */
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
    std::vector<double> measured_N;
    std::vector<double> true_m;
    std::vector<double> true_N;
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

/* What J2 and J3 would be if the hardware did exactly what is simulated: the sensor's noise alone. */
struct noise_share {
    double spread_percent;
    double peak_percent;
};
noise_share noise_alone(const run_record &record);

} // namespace berth::rths

#endif
