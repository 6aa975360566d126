#include <cmath>

#include "effects.h"

namespace berth
{

namespace
{

class periodic_error final : public motion_stage
{
  public:
    periodic_error(double amplitude_m, double pitch_m, double phase_rad)
        : amplitude_m_(amplitude_m), rad_per_m_(2.0 * 3.14159265358979323846 / pitch_m), phase_rad_(phase_rad)
    {
    }
    void start(double) override {}
    bool has_memory() const override { return false; }
    double advance(double value, double) override
    {
        return value + amplitude_m_ * std::sin(rad_per_m_ * value + phase_rad_);
    }

  private:
    double amplitude_m_;
    double rad_per_m_;
    double phase_rad_;
};

} // namespace

effect robot_periodic_error()
{
    effect made;
    made.name = "robot.periodic_error";
    made.physics = "An error that repeats over the path: r = r0 + a sin(2 pi r0 / L + phi).";
    made.source = "gear teeth, strain-wave gears, spindles";
    made.calibration = {
        20, "move the robot slowly over several turns of its gears, and measure the way with another instrument"};
    made.parameters = {{"robot.periodic_error_m", 0.0, 1.0, "a of an error a sin(2 pi x / L + phi)"},
                       {"robot.periodic_error_pitch_m", 1e-9, 100.0, "L of the periodic error"},
                       {"robot.periodic_error_phase_rad", -7.0, 7.0, "phi of the periodic error"}};
    made.starts = [](const rig &, const record_scales &scales) {
        std::vector<effect_values> all;
        std::vector<double> pitches_m = scales.residual_pitch_m;
        if (!pitches_m.empty()) { /* of so few periods no line tells */
            pitches_m.insert(pitches_m.end(), {1.4 * scales.position_m, 2.0 * scales.position_m});
        }
        for (const double pitch_m : pitches_m) {
            for (const double phase_rad : {-2.356, -0.785, 0.785, 2.356}) {
                all.push_back({1.4 * scales.residual_m, pitch_m, phase_rad});
            }
        }
        return all;
    };
    made.on_motion = [](const rig &rig) -> std::unique_ptr<motion_stage> {
        return std::make_unique<periodic_error>(value_of(rig, "robot.periodic_error_m"),
                                                value_of(rig, "robot.periodic_error_pitch_m"),
                                                value_of(rig, "robot.periodic_error_phase_rad"));
    };
    made.reach = 3.0;
    made.is_seen = [](const rig &fitted, const record_scales &scales) {
        /* One and a half periods on the path: less may be the bend of some other curve. */
        return 1.5 * value_of(fitted, "robot.periodic_error_pitch_m") < 2.0 * scales.position_m;
    };
    made.is_curve = true;
    made.is_proportional = true;
    made.hides_in_reports = true;
    made.generalises = "robot.gain";
    return made;
}

} // namespace berth
