#include "effects.h"
#include "starts.h"

namespace berth
{

effect sensor_delay()
{
    effect made;
    made.name = "sensor.delay";
    made.physics = "The force comes later or earlier than told: another T_S.";
    made.source = "data sheets of force sensors";
    made.calibration = {7, "tap the sensor while another instrument records the tap on the clock of the loop"};
    made.parameters = {{"sensor.delay_ms", 0.0, 1000.0, {}}};
    made.look_alike = "robot.dead_time"; /* unless the robot reports its position */
    made.starts = [](const rig &base, const record_scales &scales) {
        return shifted(base.sensor.delay_ms, 1e3 * scales.period_s);
    };
    return made;
}

} // namespace berth
