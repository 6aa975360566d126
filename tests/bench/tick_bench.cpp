/* Times one firmware tick on inputs that a run of the reference case met.
 *
 *   tick_bench time RIG SECONDS PASSES [KEY=VALUE...]   a JSON object: ticks one by one and in batches
 *   tick_bench step RIG SECONDS TICKS [KEY=VALUE...]    the first TICKS of them and nothing else, to be counted
 *                                                       from outside
 */
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "../../firmware/app.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/sim_hal.h"

namespace
{

constexpr int clock_readings = 100000;
constexpr std::size_t batch_ticks = 16; /* long against the step of a clock, which may be 10 ns */

std::vector<hal_frame> received_frames(hal *hal)
{
    std::vector<hal_frame> frames;
    hal_frame frame;
    for (const hal_bus bus : {HAL_BUS_SENSOR, HAL_BUS_ROBOT}) {
        while (frames.size() < TICK_FRAMES_IN_MAX && hal_can_receive(hal, bus, &frame) == HAL_OK) {
            frames.push_back(frame);
        }
    }
    return frames;
}

/* Runs the loop once and keeps what the firmware was given at every tick. */
std::vector<tick_input> recorded_inputs(const berth::rig &rig)
{
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &rig.firmware);
    hal *hal = berth::sim_open(rig);
    std::vector<tick_input> inputs;
    tick_input in{};
    while (hal_wait_tick(hal, &in.tick) == HAL_OK) {
        const std::vector<hal_frame> frames = received_frames(hal);
        std::copy(frames.begin(), frames.end(), in.frames);
        in.frame_count = static_cast<uint32_t>(frames.size());
        hal_gpio_get(hal, HAL_LINE_ENABLE, &in.enable);
        hal_gpio_get(hal, HAL_LINE_EMERGENCY_STOP, &in.emergency_stop);
        tick_output out;
        app_step(app.get(), &in, &out);
        for (uint32_t i = 0; i < out.frame_count; i++) {
            hal_can_send(hal, &out.frames[i]);
        }
        hal_record(hal, app->recorder.bytes, app->recorder.size_bytes);
        inputs.push_back(in);
    }
    hal_close(hal);
    return inputs;
}

double quantile(std::vector<double> &values, double share)
{
    const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + place, values.end());
    return values[static_cast<std::size_t>(place)];
}

template <typename Work>
double duration_ns(const Work &work)
{
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
}

/* Two readings of the clock with nothing in between are this far apart. */
double clock_reading_ns()
{
    std::vector<double> distances_ns(clock_readings);
    for (double &distance_ns : distances_ns) {
        distance_ns = duration_ns([] {});
    }
    return quantile(distances_ns, 0.5);
}

/* Time per tick of `at_once` ticks between two readings of the clock, over all inputs and passes. The inputs are in
 * the cache, as after reading them from the buses. */
std::vector<double> tick_times_ns(const berth::rig &rig, const std::vector<tick_input> &inputs, int passes,
                                  std::size_t at_once, double reading_ns)
{
    const auto app = std::make_unique<struct app>();
    std::vector<double> times_ns;
    std::array<tick_input, batch_ticks> in;
    tick_output out;
    for (int pass = 0; pass < passes; pass++) {
        app_start(app.get(), &rig.firmware);
        for (std::size_t first = 0; first + at_once <= inputs.size(); first += at_once) {
            std::copy_n(&inputs[first], at_once, in.begin());
            const double elapsed_ns = duration_ns([&] {
                for (std::size_t i = 0; i < at_once; i++) {
                    app_step(app.get(), &in[i], &out);
                }
            });
            times_ns.push_back((elapsed_ns - reading_ns) / static_cast<double>(at_once));
        }
    }
    return times_ns;
}

void step(const berth::rig &rig, const std::vector<tick_input> &inputs, std::size_t ticks)
{
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &rig.firmware);
    tick_output out;
    for (std::size_t i = 0; i < std::min(ticks, inputs.size()); i++) {
        app_step(app.get(), &inputs[i], &out);
    }
}

void time_ticks(const berth::rig &rig, const std::vector<tick_input> &inputs, int passes)
{
    const double reading_ns = clock_reading_ns();
    std::vector<double> singles_ns = tick_times_ns(rig, inputs, passes, 1, reading_ns);
    std::vector<double> batches_ns = tick_times_ns(rig, inputs, passes, batch_ticks, reading_ns);
    std::printf("{\"ticks\": %zu, \"clock_reading_ns\": %.1f, \"median_ns\": %.1f, \"p99_9_ns\": %.1f, "
                "\"batch_ticks\": %zu, \"batch_median_ns\": %.2f}\n",
                singles_ns.size(), reading_ns, quantile(singles_ns, 0.5), quantile(singles_ns, 0.999), batch_ticks,
                quantile(batches_ns, 0.5));
}

} // namespace

int main(int argc, char **argv)
{
    if (argc < 5) {
        std::fprintf(stderr, "usage: tick_bench time|step RIG SECONDS PASSES|TICKS [KEY=VALUE...]\n");
        return 2;
    }
    std::vector<std::string> overrides(argv + 5, argv + argc);
    overrides.push_back(std::string("run.duration_s=") + argv[3]);
    const berth::rig rig = berth::load_rig(argv[2], overrides);
    const std::vector<tick_input> inputs = recorded_inputs(rig);
    const std::size_t count = std::strtoul(argv[4], nullptr, 10);
    if (std::strcmp(argv[1], "time") == 0) {
        time_ticks(rig, inputs, std::max<int>(1, static_cast<int>(count)));
    } else {
        step(rig, inputs, count);
    }
    return 0;
}
