#include "effects.h"

namespace berth
{

effect loop_clock_drift()
{
    effect made;
    made.name = "loop.clock_drift";
    made.physics =
        "The robot takes the newest setpoint at ticks of its own clock, which runs off: the dead time is T_R and "
        "a sawtooth between 0 and T.";
    made.source = "two quartzes";
    made.calibration = {22, "count the robot's own cycles against the loop's over an hour"};
    made.parameters = {{"robot.clock_drift_ppm", -5000.0, 5000.0, {}}, {"robot.clock_phase_ms", 0.0, 100.0, {}}};
    made.starts = [](const rig &, const record_scales &scales) {
        std::vector<effect_values> all;
        for (const clock_guess &guess : scales.clocks) {
            all.push_back({guess.drift_ppm, guess.phase_ms});
        }
        for (const double periods : {-5.0, -3.0, -2.0, -1.4, -1.0, -0.6, -0.3, 0.3, 0.6, 1.0, 1.4, 2.0, 3.0, 5.0}) {
            for (const double phase : {0.1, 0.3, 0.5, 0.7, 0.9}) {
                all.push_back({1e6 * periods * scales.period_s / scales.duration_s, 1e3 * phase * scales.period_s});
            }
        }
        return all;
    };
    made.switch_on = [](rig &rig) { rig.robot.clock = robot_clock::free; };
    made.sizes = 1;
    made.switches = true; /* which setpoint is the newest when the robot looks */
    made.fits_max = 5;    /* each wrap of the clock makes a valley of its own */
    made.acts_in_robot = true;
    return made;
}

} // namespace berth
