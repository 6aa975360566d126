#include <algorithm>
#include <cmath>

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
    void start(double value) override { start_seen(value, value); }
    void start_seen(double value, double seen) override
    {
        driven_m_ = value;
        held_m_ = std::min(std::max(seen, value - half_m_), value + half_m_);
    }
    double advance(double value, double) override
    {
        const double before_m = held_m_;
        held_m_ = std::min(std::max(held_m_, value - half_m_), value + half_m_);
        moved_m_ = held_m_ - before_m;
        way_m_ = value - driven_m_;
        driven_m_ = value;
        return held_m_;
    }
    double bulge() const override
    {
        /* It stood until the gap was crossed, and went with the drive for the rest of the step. */
        constexpr double rounded =
            1e-9; /* of the way: the drive's and the tool's are differences of other numbers */
        const bool is_straight = moved_m_ == 0.0 || std::abs(way_m_ - moved_m_) <= rounded * std::abs(way_m_);
        return is_straight ? 0.0 : 0.5 * (moved_m_ / way_m_ - 1.0) * moved_m_;
    }

  private:
    double half_m_;
    double held_m_ = 0.0;
    double driven_m_ = 0.0;
    double way_m_ = 0.0; /* of the drive on the last step */
    double moved_m_ = 0.0;
};

} // namespace

effect robot_backlash()
{
    effect made;
    made.name = "robot.backlash";
    made.physics = "Play in the gears: r stays until the reference u has moved through the gap b, then follows: "
                   "r = clamp(r, u - b/2, u + b/2).";
    made.source = "the play operator, Brokate & Sprekels, Hysteresis and Phase Transitions";
    made.calibration = {
        18, "push and pull the robot by hand while it holds its place, and read the way with a dial gauge"};
    made.parameters = {{"robot.backlash_m", 0.0, 10.0, "full width of the play"}};
    made.hides_in_reports = true;
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes_of(scales.position_m, {0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3});
    };
    made.on_motion = [](const rig &rig) -> std::unique_ptr<motion_stage> {
        return std::make_unique<play>(0.5 * value_of(rig, "robot.backlash_m"));
    };
    return made;
}

} // namespace berth
