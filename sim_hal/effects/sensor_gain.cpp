#include "effects.h"
#include "starts.h"

namespace berth
{

namespace
{

class force_gain final : public sample_stage
{
  public:
    explicit force_gain(double factor) : factor_(factor) {}
    double take(double force_N, double) override { return factor_ * force_N; }

  private:
    double factor_;
};

} // namespace

effect sensor_gain()
{
    effect made;
    made.name = "sensor.gain";
    made.physics = "The sensor shows too much or too little: y = (1 + e) F.";
    made.source = "calibration";
    made.calibration = {1, "load the sensor with a known mass at rest, and compare what it shows with the weight"};
    made.parameters = {{"sensor.gain_error", -0.9, 5.0, "e: the sensor shows (1 + e) F"}};
    made.starts = [](const rig &, const record_scales &) { return both_signs({0.05}); };
    made.on_samples = [](const rig &rig) -> std::unique_ptr<sample_stage> {
        return std::make_unique<force_gain>(1.0 + value_of(rig, "sensor.gain_error"));
    };
    made.is_proportional = true;
    made.look_alike = "object.parameters";
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
