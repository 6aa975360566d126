#include "effects.h"
#include "starts.h"

namespace berth
{

namespace
{

class drifting_spring final : public force_stage
{
  public:
    explicit drifting_spring(double rate_N_per_m_s) : rate_N_per_m_s_(rate_N_per_m_s) {}
    double force_N(const body_motion &motion, double) override
    {
        return rate_N_per_m_s_ * motion.time_s * motion.deflection_m;
    }

  private:
    double rate_N_per_m_s_;
};

} // namespace

effect object_stiffness_drift()
{
    effect made;
    made.name = "object.stiffness_drift";
    made.physics = "The object's spring changes while the loop runs: k (1 + r t).";
    made.source = "temperature, foam that settles";
    made.calibration = {29,
                        "pull the object over a known way before a long run and after it, and compare the forces"};
    made.parameters = {{"object.stiffness_drift_per_s", -1.0, 1.0, "r: stiffness k (1 + r t)"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return both_signs({0.1 / scales.duration_s, 0.5 / scales.duration_s});
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<drifting_spring>(rig.object.stiffness_N_per_m *
                                                 value_of(rig, "object.stiffness_drift_per_s"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::drifts;
    return made;
}

} // namespace berth
