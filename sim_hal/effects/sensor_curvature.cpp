#include "effects.h"
#include "starts.h"

namespace berth
{

namespace
{

class even_term final : public sample_stage
{
  public:
    explicit even_term(double curvature_per_N) : curvature_per_N_(curvature_per_N) {}
    double take(double force_N, double) override { return force_N + curvature_per_N_ * force_N * force_N; }

  private:
    double curvature_per_N_;
};

} // namespace

effect sensor_curvature()
{
    effect made;
    made.name = "sensor.curvature";
    made.physics = "The sensor's curve is bent, and pulls read otherwise than pushes: y = F + c F^2.";
    made.source = "the even term of a force sensor's calibration curve (ISO 376)";
    made.calibration = {4,
                        "load the sensor with the same known masses in both directions, and compare what it shows"};
    made.parameters = {{"sensor.curvature_per_N", -1.0, 1.0, "c: the sensor shows F + c F^2"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return both_signs({0.05 / std::max(1e-12, scales.force_N)});
    };
    made.on_samples = [](const rig &rig) -> std::unique_ptr<sample_stage> {
        return std::make_unique<even_term>(value_of(rig, "sensor.curvature_per_N"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::higher_order;
    return made;
}

} // namespace berth
