#include "effects.h"

namespace berth
{

effect robot_resonance()
{
    effect made;
    made.name = "robot.resonance";
    made.physics = "The robot swings about its goal, or with z > 1 comes up to it with two lags: G_R(s) = w^2 / "
                   "(s^2 + 2 z w s + w^2).";
    made.source = "Krenn & Schaefer, Fig. 5; elastic joints and gears";
    made.calibration = {17,
                        "tap the robot while it holds its place, and record how it rings with another instrument"};
    made.parameters = {{"robot.transfer_frequency_Hz", 0.3, 1000.0, {}},
                       {"robot.transfer_damping_ratio", 0.005, 1.25, {}}};
    made.look_alike = "robot.dead_time";
    made.starts = [](const rig &, const record_scales &scales) {
        std::vector<effect_values> all;
        for (const double frequency_Hz : {2.0, 4.0, 8.0, 16.0, 32.0}) {
            if (frequency_Hz < 0.4 / scales.period_s) {
                all.push_back({frequency_Hz, 0.2});
                all.push_back({frequency_Hz, 0.8});
            }
        }
        return all;
    };
    made.generalises = "robot.lag";
    return made;
}

} // namespace berth
