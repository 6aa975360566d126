/* Does the loop make energy, and where: what a run's result tells of the firmware's energy account. */
#ifndef SIM_HAL_CLI_ENERGY_REPORT_H
#define SIM_HAL_CLI_ENERGY_REPORT_H

#include <nlohmann/json.hpp>
#include <optional>

#include "../../firmware/energy_account.h"
#include "../../firmware/recorder.h"
#include "../motion.h"
#include "../thinned_signal.h"

namespace berth
{

class energy_report
{
  public:
    /* Takes one tick of running into account. */
    void note_tick(const tick_record &record);

    /* Whether the loop made more energy than damping and hardware took, over the second half of its running, or in
     * all if that had come to rest; nothing where there was no energy, or an arm, whose own damping nobody knows: it
     * is in what its joints gave. */
    std::optional<bool> gains() const;

    /* One line; none if the loop never ran. */
    void print() const;

    nlohmann::json as_json() const;

    bool has_arm = false;

  private:
    energy_sums last_{};
    /* Stored in the manipulator less what the operator gave. */
    thinned_signal not_by_operator_J_{thinning::first, kept_ticks_max};
};

} // namespace berth

#endif
