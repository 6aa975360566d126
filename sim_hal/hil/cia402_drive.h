/* The simulated robot as a CiA 402 drive: power state machine, modes of operation, cyclic synchronous position. Its
 * motion is the robot's: a setpoint that acts at a SYNC is passed by robot.dead_time_ms later. */
#ifndef SIM_HAL_HIL_CIA402_DRIVE_H
#define SIM_HAL_HIL_CIA402_DRIVE_H

#include "canopen_node.h"
#include "robot.h"

namespace berth
{

class cia402_drive : public canopen_node
{
  public:
    cia402_drive(const rig &rig, robot &robot, can_bus &bus);

    enum class power_state { switch_on_disabled, ready_to_switch_on, switched_on, operation_enabled, fault };

    power_state power() const { return power_; }

    /* Where the robot is, for the samples that are due. */
    void set_position_m(double position_m);

    /* An error of the drive's own, and its end: the fault itself stays until it is reset. */
    void set_fault(bool is_present, std::int64_t now_ns);

  protected:
    std::uint32_t check_write(od_key key, std::uint32_t value) override;
    void written(od_key key) override;
    void synchronised(std::int64_t sent_ns) override;
    void connection_aborted() override;

  private:
    void obey(std::uint16_t controlword);
    void enter(power_state state);
    void fail(std::uint16_t error_code, std::uint8_t error_register);

    robot &robot_;
    double counts_per_m_;
    power_state power_ = power_state::switch_on_disabled;
    std::uint16_t controlword_ = 0;
    bool error_is_present_ = false;
};

} // namespace berth

#endif
