/* How often the reaction wheel of an arm's satellite held all that it can: what a run's result tells of it. */
#ifndef SIM_HAL_CLI_WHEEL_REPORT_H
#define SIM_HAL_CLI_WHEEL_REPORT_H

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "../../firmware/arm/arm_config.h"
#include "../../firmware/arm/arm_record.h"

namespace berth
{

class wheel_report
{
  public:
    /* Takes one tick of running into account. */
    void note_tick(std::int64_t tick, const arm_record &record, const attitude_config &config);

    bool any() const { return ticks_ > 0; }

    /* One line; none without a wheel. */
    void print(double period_s, const attitude_config &config) const;

    /* null: there is no wheel. */
    nlohmann::json as_json(double period_s, const attitude_config &config) const;

  private:
    std::uint32_t ticks_ = 0;     /* about any axis */
    std::int64_t first_tick_ = 0; /* where there are any */
    std::array<std::uint32_t, 3> axis_ticks_{};
};

} // namespace berth

#endif
