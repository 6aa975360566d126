#include "effects.h"
#include "starts.h"

namespace berth
{

namespace
{

class drift final : public sample_stage
{
  public:
    explicit drift(double rate_N_per_s) : rate_N_per_s_(rate_N_per_s) {}
    double take(double force_N, double time_s) override { return force_N + rate_N_per_s_ * time_s; }

  private:
    double rate_N_per_s_;
};

} // namespace

effect sensor_drift()
{
    effect made;
    made.name = "sensor.drift";
    made.physics = "The zero of the sensor wanders: y = F + r t.";
    made.source = "strain gauges and temperature";
    made.calibration = {3, "read the sensor with nothing attached to it for as long as the record lasted"};
    made.parameters = {{"sensor.drift_N_per_s", -1e6, 1e6, "r: the zero wanders by r t"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return both_signs({0.05 * scales.force_N / scales.duration_s});
    };
    made.on_samples = [](const rig &rig) -> std::unique_ptr<sample_stage> {
        return std::make_unique<drift>(value_of(rig, "sensor.drift_N_per_s"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::no_influence;
    return made;
}

} // namespace berth
