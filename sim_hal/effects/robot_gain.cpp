#include "effects.h"
#include "starts.h"

namespace berth
{

namespace
{

class setpoint_gain_stage final : public setpoint_stage
{
  public:
    explicit setpoint_gain_stage(double factor) : factor_(factor) {}
    void start(double) override {}
    double take(double setpoint_m) override { return factor_ * setpoint_m; }
    std::unique_ptr<setpoint_stage> copy() const override { return std::make_unique<setpoint_gain_stage>(*this); }

  private:
    double factor_;
};

} // namespace

effect robot_gain()
{
    effect made;
    made.name = "robot.gain";
    made.physics = "The robot goes too far or not far enough: r = (1 + e) x.";
    made.source = "calibration of drives and kinematics; Krenn & Schaefer, Fig. 5";
    made.calibration = {
        4, "move the robot between two places, and measure the way with another instrument (dial gauge, laser)"};
    made.parameters = {{"robot.gain_error", -0.9, 2.0, "e: the robot goes to (1 + e) x"}};
    made.look_alike = "sensor.gain"; /* unless the robot reports its position */
    made.starts = [](const rig &, const record_scales &) { return both_signs({0.03}); };
    made.on_setpoints = [](const rig &rig) -> std::unique_ptr<setpoint_stage> {
        return std::make_unique<setpoint_gain_stage>(1.0 + value_of(rig, "robot.gain_error"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
