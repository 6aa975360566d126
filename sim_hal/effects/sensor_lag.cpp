#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

effect sensor_lag()
{
    effect made;
    made.name = "sensor.lag";
    made.physics = "One more first-order low-pass in the sensor: tau y' = F - y.";
    made.source = "data sheets of force sensors";
    made.calibration = {8, "tap the sensor while another instrument records the tap on the clock of the loop"};
    made.parameters = {{"sensor.lag_ms", 0.0, 2000.0, "tau of one more first-order low-pass"}};
    made.look_alike = "robot.lag"; /* unless the robot reports its position */
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes({1e3 * scales.period_s, 6e3 * scales.period_s, 40.0});
    };
    made.on_force = [](const rig &rig) -> std::unique_ptr<motion_stage> {
        return std::make_unique<first_order_lag>(1e-3 * value_of(rig, "sensor.lag_ms"));
    };
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
