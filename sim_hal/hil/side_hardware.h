/* Robot, sensor spring, object and low-pass along one of the robot's axes beside that of the loop: the plant of
 * plant.h once more, with its own dead time. The axes meet in the manipulator and in the force sensor, not here. */
#ifndef SIM_HAL_HIL_SIDE_HARDWARE_H
#define SIM_HAL_HIL_SIDE_HARDWARE_H

#include "../solver/gripped_plant.h"
#include "robot.h"

namespace berth
{

class side_hardware
{
  public:
    side_hardware(const rig &rig, std::size_t axis);

    std::size_t axis() const { return axis_; } /* enum side_axis */

    /* Lets everything happen up to and including `now_ns`. Time never runs backwards. */
    void advance_to(std::int64_t now_ns);

    /* As robot::receive(); frames of other axes are not looked at. */
    void receive(const hal_frame &frame, std::int64_t arrival_ns) { robot_.receive(frame, arrival_ns); }

    double robot_position() const; /* m, or rad */
    double measured_force() const; /* after the low-pass: N, or N m */
    std::uint8_t setpoint_counter() const { return robot_.setpoint_counter(); }

  private:
    void travel_to(std::int64_t time_ns);
    void move_reference();

    std::size_t axis_;
    berth::robot robot_;
    gripped_plant plant_;
    std::int64_t now_ns_ = 0;
};

/* Of the axes that a rig has. */
std::vector<std::unique_ptr<side_hardware>> make_side_hardware(const rig &rig);

std::uint32_t side_setpoint_id(std::size_t axis);
std::uint32_t side_feedback_id(std::size_t axis);

} // namespace berth

#endif
