/* What the guidance of an arm had to hold back of the operator's orders: what a run's result tells of it. */
#ifndef SIM_HAL_CLI_GUIDANCE_REPORT_H
#define SIM_HAL_CLI_GUIDANCE_REPORT_H

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "../../firmware/arm/arm_record.h"
#include "../../firmware/arm/guidance_order.h"

namespace berth
{

class guidance_report
{
  public:
    /* Takes one tick of running into account. */
    void note_tick(std::int64_t tick, const arm_record &record);

    /* One line. */
    void print(double period_s) const;

    nlohmann::json as_json(double period_s) const;

  private:
    struct of_limit {
        std::uint32_t ticks = 0;
        std::int64_t first_tick = 0; /* where there are any */
    };
    std::array<of_limit, GUIDANCE_LIMIT_COUNT> limits_{};
};

} // namespace berth

#endif
