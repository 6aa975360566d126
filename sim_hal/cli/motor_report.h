/* How often the motors of an arm were at their torque limits: what a run's result tells of it. */
#ifndef SIM_HAL_CLI_MOTOR_REPORT_H
#define SIM_HAL_CLI_MOTOR_REPORT_H

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "../../firmware/arm/arm_config.h"
#include "../../firmware/arm/arm_record.h"

namespace berth
{

class motor_report
{
  public:
    bool is_told = true; /* false: read from a log that does not know */

    /* Takes one tick of running into account. */
    void note_tick(std::int64_t tick, const arm_record &record);

    bool any() const { return ticks_ > 0; }

    /* One line. */
    void print(double period_s) const;

    /* null: not told. */
    nlohmann::json as_json(double period_s, std::int64_t joint_count) const;

  private:
    std::uint32_t ticks_ = 0;     /* any of them was */
    std::int64_t first_tick_ = 0; /* where there are any */
    std::array<std::uint32_t, ARM_JOINTS_MAX> joint_ticks_{};
};

} // namespace berth

#endif
