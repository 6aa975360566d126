#include <algorithm>
#include <cmath>

#include "effects.h"

namespace berth
{

namespace
{

class hysteresis final : public force_stage
{
  public:
    hysteresis(double force_N, double length_m, double exponent)
        : force_N_(force_N), length_m_(length_m), exponent_(exponent)
    {
    }
    void start(const body_motion &motion) override { before_m_ = motion.position_m; }
    double force_N(const body_motion &motion, double) override
    {
        const double way = (motion.position_m - before_m_) / length_m_;
        before_m_ = motion.position_m;
        const double direction = way < 0.0 ? -1.0 : 1.0;
        if (exponent_ == 0.0) { /* exact over the way, whatever its length */
            z_ = direction + (z_ - direction) * std::exp(-std::abs(way));
        } else {
            constexpr double way_max = 0.1;
            const int parts = std::min(100, 1 + static_cast<int>(std::abs(way) / way_max));
            for (int i = 0; i < parts; i++) {
                const double held = direction * z_ > 0.0 ? std::pow(std::abs(z_), exponent_) : 0.0;
                z_ = std::min(1.0, std::max(-1.0, z_ + way / parts * (1.0 - held)));
            }
        }
        return force_N_ * z_;
    }

  private:
    double force_N_;
    double length_m_;
    double exponent_;
    double before_m_ = 0.0;
    double z_ = 0.0;
};

} // namespace

effect object_hysteresis()
{
    effect made;
    made.name = "object.hysteresis";
    made.physics =
        "Friction that builds up over a length: a further force Fh z, z' = x'/xh (1 - sign(x') z) (Dahl), or "
        "z' = x'/xh (1 - |z|^n (1 + sign(x' z))/2) (Bouc-Wen).";
    made.source = "Dahl 1968; Bouc 1967, Wen 1976";
    made.calibration = {10, "pull the object slowly over short ways, and record its force over the way"};
    made.parameters = {{"object.hysteresis_force_N", 0.0, 1e7, "Fh, largest force of the hysteresis"},
                       {"object.hysteresis_length_m", 1e-9, 10.0, "xh, over which it builds up"},
                       {"object.hysteresis_exponent", 0.0, 6.0, "exponent n of Bouc-Wen; 0: Dahl"}};
    made.starts = [](const rig &, const record_scales &scales) {
        std::vector<effect_values> all;
        for (const double share : {0.05, 0.3}) {
            all.push_back({0.1 * scales.force_N, share * scales.position_m, 0.0});
            all.push_back({0.1 * scales.force_N, share * scales.position_m, 1.5});
        }
        return all;
    };
    made.reach = 5.0; /* over a shorter way it is dry friction */
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<hysteresis>(value_of(rig, "object.hysteresis_force_N"),
                                            value_of(rig, "object.hysteresis_length_m"),
                                            value_of(rig, "object.hysteresis_exponent"));
    };
    made.is_proportional = true;
    made.generalises = "object.coulomb_friction";
    return made;
}

} // namespace berth
