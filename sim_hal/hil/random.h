/* Seeded random streams. Every block has its own, so that switching one effect on does not change another's draws.
 */
#ifndef SIM_HAL_HIL_RANDOM_H
#define SIM_HAL_HIL_RANDOM_H

#include <cstdint>
#include <random>

namespace berth
{

class random_stream
{
  public:
    random_stream(std::int64_t seed, std::uint32_t stream)
    {
        std::seed_seq sequence{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32), stream};
        engine_.seed(sequence);
    }

    /* True with this probability; draws nothing if it is 0. */
    bool happens(double probability) { return probability > 0.0 && uniform() < probability; }

    /* From 0 to 1, 1 excluded. */
    double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

    /* Mean 0, standard deviation 1. */
    double normal() { return normal_(engine_); }

  private:
    std::mt19937_64 engine_;
    std::normal_distribution<double> normal_;
};

enum random_stream_id : std::uint32_t {
    stream_robot_bus,
    stream_sensor_bus,
    stream_sensor,
    stream_robot,
    stream_profile,
    stream_lateness,
    stream_disturbance,
    stream_feedback,
    stream_lost_commands,
    stream_spikes,
    stream_lost_samples
};

} // namespace berth

#endif
