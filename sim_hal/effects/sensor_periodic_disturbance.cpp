#include <cmath>

#include "effects.h"

namespace berth
{

namespace
{

class hum final : public sample_stage
{
  public:
    hum(double amplitude_N, double frequency_Hz, double phase_rad)
        : amplitude_N_(amplitude_N), w_(2.0 * 3.14159265358979323846 * frequency_Hz), phase_rad_(phase_rad)
    {
    }
    double take(double force_N, double time_s) override
    {
        return force_N + amplitude_N_ * std::sin(w_ * time_s + phase_rad_);
    }

  private:
    double amplitude_N_;
    double w_;
    double phase_rad_;
};

} // namespace

effect sensor_periodic_disturbance()
{
    effect made;
    made.name = "sensor.periodic_disturbance";
    made.physics = "Something that has nothing to do with the motion hums into the force: a sin(2 pi f t + phi).";
    made.source = "mains, fans, pumps";
    made.calibration = {23,
                        "read the sensor with nothing attached to it, with the robot's drives on and with them off"};
    made.parameters = {{"sensor.periodic_N", 0.0, 1e6, "a of a disturbance a sin(2 pi f t + phi)"},
                       {"sensor.periodic_frequency_Hz", 0.01, 5000.0, "f of the periodic disturbance"},
                       {"sensor.periodic_phase_rad", -7.0, 7.0, "phi of the periodic disturbance"}};
    made.starts = [](const rig &, const record_scales &scales) {
        std::vector<effect_values> all;
        if (scales.residual_frequency_Hz > 0.0) {
            for (const double phase_rad : {-2.356, -0.785, 0.785, 2.356}) {
                all.push_back({1.4 * scales.residual, scales.residual_frequency_Hz, phase_rad});
            }
        }
        return all;
    };
    made.on_samples = [](const rig &rig) -> std::unique_ptr<sample_stage> {
        return std::make_unique<hum>(value_of(rig, "sensor.periodic_N"),
                                     value_of(rig, "sensor.periodic_frequency_Hz"),
                                     value_of(rig, "sensor.periodic_phase_rad"));
    };
    made.is_proportional = true;
    made.is_of_time_alone = true;
    made.is_seen = [](const rig &fitted, const record_scales &scales) {
        /* Ten periods: fewer are slow noise, of which no sine is nearly all. */
        const double periods = value_of(fitted, "sensor.periodic_frequency_Hz") * scales.duration_s;
        const double amplitude_N = value_of(fitted, "sensor.periodic_N");
        const double share = 0.5 * amplitude_N * amplitude_N / (scales.residual * scales.residual);
        return periods > 10.0 || (periods > 5.0 && share > 0.85);
    };
    made.when_small = small_motion::no_influence;
    return made;
}

} // namespace berth
