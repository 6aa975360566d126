#include "effects.h"

namespace berth
{

effect robot_lost_commands()
{
    effect made;
    made.name = "robot.lost_commands";
    made.physics = "A setpoint is lost with probability p; the robot stands at its last one until the next.";
    made.source = "bus load, connectors";
    made.parameters = {
        {"robot.lost_command_probability", 0.0, 1.0, "probability that a setpoint never reaches the robot"}};
    made.is_of_single_samples = true;
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
