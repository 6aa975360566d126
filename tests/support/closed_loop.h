/* A whole loop in one object: firmware and simulated rig, stepped tick by tick. */
#ifndef TESTS_SUPPORT_CLOSED_LOOP_H
#define TESTS_SUPPORT_CLOSED_LOOP_H

#include <memory>
#include <string>
#include <vector>

#include "../../firmware/loop.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/sim_hal.h"
#include "../../sim_hal/stability/growth_fit.h"

namespace berth
{

class closed_loop
{
  public:
    explicit closed_loop(const rig &rig, const std::string &log_path = "")
        : app_(std::make_unique<struct app>()), hal_(sim_open(rig, {log_path, {}, nullptr}))
    {
        app_start(app_.get(), &rig.firmware);
    }
    explicit closed_loop(const std::string &name, const std::vector<std::string> &overrides = {})
        : closed_loop(load_rig(name, overrides))
    {
    }
    closed_loop(const closed_loop &) = delete;
    closed_loop &operator=(const closed_loop &) = delete;
    ~closed_loop() { hal_close(hal_); }

    /* False at the end of the run. */
    bool tick() { return loop_tick(hal_, app_.get()) == HAL_OK; }

    /* Ticks until it runs; it is asked to as soon as it was ready for a tick, which needs no enable. */
    void start()
    {
        sim_set_input(hal_, HAL_LINE_ENABLE, HAL_LEVEL_NOT_WIRED);
        operator_station &operators = sim_rig(hal_).operators();
        operators.set_request(OPERATOR_NONE);
        for (int ready_ticks = 0; !is_running() && tick();) {
            ready_ticks = app_->supervisor.state == SUPERVISOR_READY ? ready_ticks + 1 : 0;
            operators.set_request(ready_ticks > 1 || is_running() ? OPERATOR_RUN : OPERATOR_NONE);
        }
    }

    const struct app &app() const { return *app_; }
    struct app &app() { return *app_; } /* for tests that put the firmware into another state */
    struct hal *hal() { return hal_; }
    rig_truth truth() const { return sim_rig(hal_).truth(); }
    bool is_running() const { return app_->supervisor.state == SUPERVISOR_RUNNING; }

  private:
    std::unique_ptr<struct app> app_;
    struct hal *hal_;
};

/* Position of the manipulator at every tick while it runs unlimited. */
inline std::vector<double> free_motion_m(closed_loop &loop)
{
    std::vector<double> positions_m;
    while (loop.tick() && (loop.app().limits.active == 0 || positions_m.empty())) {
        if (loop.is_running() && loop.app().limits.active == 0) {
            positions_m.push_back(loop.app().recorder.tick.manipulator_position_m);
        }
    }
    return positions_m;
}

} // namespace berth

#endif
