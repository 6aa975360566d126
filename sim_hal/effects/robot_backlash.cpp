#include <algorithm>

#include "effects.h"
#include "starts.h"

namespace berth
{

namespace
{

class play final : public motion_stage
{
  public:
    explicit play(double half_m) : half_m_(half_m) {}
    void start(double value) override { held_m_ = value; }
    double advance(double value, double) override
    {
        held_m_ = std::min(std::max(held_m_, value - half_m_), value + half_m_);
        return held_m_;
    }

  private:
    double half_m_;
    double held_m_ = 0.0;
};

} // namespace

effect robot_backlash()
{
    effect made;
    made.name = "robot.backlash";
    made.physics = "Play in the gears: r stays until the reference u has moved through the gap b, then follows: "
                   "r = clamp(r, u - b/2, u + b/2).";
    made.source = "the play operator, Brokate & Sprekels, Hysteresis and Phase Transitions";
    made.parameters = {{"robot.backlash_m", 0.0, 10.0, "full width of the play"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes_of(scales.position_m, {0.003, 0.01, 0.03, 0.1, 0.3});
    };
    made.on_motion = [](const rig &rig) -> std::unique_ptr<motion_stage> {
        return std::make_unique<play>(0.5 * value_of(rig, "robot.backlash_m"));
    };
    return made;
}

} // namespace berth
