#include <cmath>

#include "effects.h"
#include "starts.h"

namespace berth
{

namespace
{

class deadband final : public setpoint_stage
{
  public:
    explicit deadband(double width_m) : width_m_(width_m) {}
    void start(double setpoint_m) override { held_m_ = setpoint_m; }
    double take(double setpoint_m) override
    {
        if (std::abs(setpoint_m - held_m_) > width_m_) {
            held_m_ = setpoint_m;
        }
        return held_m_;
    }
    std::unique_ptr<setpoint_stage> copy() const override { return std::make_unique<deadband>(*this); }

  private:
    double width_m_;
    double held_m_ = 0.0;
};

} // namespace

effect robot_deadband()
{
    effect made;
    made.name = "robot.deadband";
    made.physics = "A setpoint nearer than delta to the one that the robot stands on is ignored; else it is taken, "
                   "then scaled.";
    made.source = "servo drives";
    made.calibration = {
        19, "command ever larger steps from rest, and read with a dial gauge which is the first to move it"};
    made.parameters = {
        {"robot.deadband_m", 0.0, 10.0, "setpoints nearer than this to the last one taken are ignored"}};
    made.starts = [](const rig &, const record_scales &scales) {
        /* Motion that ignores up to delta is off by up to delta; a size that is wrong by a twentieth jumps at other
         * moments and explains nothing. */
        std::vector<effect_values> all = grid_of(scales.residual_peak, 0.8, 1.25, 12);
        const std::vector<effect_values> more = grid_of(scales.position_m, 1e-4, 0.5, 24);
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    made.on_setpoints = [](const rig &rig) -> std::unique_ptr<setpoint_stage> {
        return std::make_unique<deadband>(value_of(rig, "robot.deadband_m"));
    };
    made.is_rough = true;
    made.acts_at_once = true;
    made.switches = true;
    made.hides_in_reports = true;
    made.fits_max = 1;
    return made;
}

} // namespace berth
