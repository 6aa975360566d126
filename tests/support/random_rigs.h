/* Rigs drawn at random: rates, dead times, interpolations, sensors and masses as real ones may have. */
#ifndef TESTS_SUPPORT_RANDOM_RIGS_H
#define TESTS_SUPPORT_RANDOM_RIGS_H

#include <cmath>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/random.h"

namespace berth
{

class rig_draw
{
  public:
    explicit rig_draw(std::int64_t seed) : random_(seed, 3) {}

    rig draw()
    {
        for (;;) {
            rig drawn = load_rig("ess");
            draw_loop(drawn);
            draw_masses(drawn);
            if (!complete_and_check(drawn)) {
                return drawn;
            }
        }
    }

  private:
    double between(double low, double high) { return low + (high - low) * random_.uniform(); }
    double log_between(double low, double high) { return low * std::pow(high / low, random_.uniform()); }

    void draw_loop(rig &rig)
    {
        constexpr std::int64_t rates_Hz[] = {50, 80, 100, 125, 160, 200, 250, 400, 500, 1000};
        rig.firmware.loop.rate_Hz = rates_Hz[static_cast<std::size_t>(between(0.0, 10.0))];
        const double period_ms = 1e3 / static_cast<double>(rig.firmware.loop.rate_Hz);
        rig.robot.interpolation = random_.happens(0.5) ? interpolation::hold : interpolation::linear;
        rig.robot.dead_time_ms = period_ms + log_between(0.5, 60.0);
        rig.sensor.delay_ms = log_between(0.5, 25.0);
        if (random_.happens(0.5)) {
            rig.robot.transfer_frequency_Hz = log_between(6.0, 30.0);
            rig.robot.transfer_damping_ratio = between(0.4, 1.0);
        }
        rig.sensor.low_pass_order = random_.happens(0.5) ? 1 : 2;
        rig.sensor.low_pass_frequency_Hz = log_between(8.0, 60.0);
        rig.sensor.low_pass_damping_ratio = between(0.5, 1.0);
    }

    void draw_masses(rig &rig)
    {
        manipulator_config &m = rig.firmware.manipulator;
        m.mass_kg = log_between(50.0, 500.0);
        m.stiffness_N_per_m = m.mass_kg * std::pow(6.283185307 * log_between(0.4, 2.5), 2.0);
        m.damping_N_s_per_m = 2.0 * between(0.01, 0.2) * std::sqrt(m.stiffness_N_per_m * m.mass_kg);
        rig.object.mass_kg = m.mass_kg * log_between(0.05, 1.2);
        rig.object.stiffness_N_per_m = m.stiffness_N_per_m * log_between(0.05, 5.0);
        rig.object.damping_N_s_per_m =
            2.0 * between(0.0, 0.1) * std::sqrt(rig.object.stiffness_N_per_m * rig.object.mass_kg);
        rig.sensor.stiffness_N_per_m = log_between(1e6, 2e7);
        rig.sensor.damping_ratio = between(0.01, 0.1);
    }

    random_stream random_;
};

} // namespace berth

#endif
