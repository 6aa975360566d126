#include "stage_run.h"

#include <Eigen/Core>
#include <memory>

#include "../../firmware/loop.h"
#include "../../hal/rig/rig_file.h"
#include "../hil/manipulator_stand_in.h"
#include "../hil/sim_hal.h"
#include "../log/recorded_tick.h"
#include "../solver/factors.h"
#include "../stability/arm_loop.h"

namespace berth
{

namespace
{

using matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using vector6 = Eigen::Matrix<double, 6, 1>;

/* Takes what the stages are judged by, tick by tick. */
class stage_observer
{
  public:
    explicit stage_observer(const rig &told)
        : motion_(told), from_robot_(matrix6::Identity()), has_wrench_(told.firmware.wrench.enabled != 0)
    {
        if (has_wrench_) {
            from_robot_ = inverse(Eigen::Map<const matrix6>(told.firmware.wrench.to_robot));
        }
        run_.load_step_s = config_period_s(&told.firmware);
    }

    void note(const app &app, std::optional<double> spring_force_N)
    {
        const tick_record &tick = app.recorder.tick;
        run_.ticks.push_back(tick);
        run_.sent_setpoint = run_.sent_setpoint || app.robot_channel.sends_setpoints != 0;
        motion_.note_tick(tick, app.arm_record.motors_at_limit != 0, spring_force_N);
        if (app.sensor_channel.has_sample) {
            run_.loads.push_back(load_of(app.sensor_channel.wrench));
        }
    }

    stage_run conclude()
    {
        run_.motion = motion_.conclude();
        return std::move(run_);
    }

  private:
    sensor_load load_of(const wrench &wrench) const
    {
        vector6 load;
        load << wrench.force_N[0], wrench.force_N[1], wrench.force_N[2], wrench.torque_N_m[0], wrench.torque_N_m[1],
            wrench.torque_N_m[2];
        sensor_load shown{};
        vector6::Map(shown.data()) = from_robot_ * load;
        return shown;
    }

    stage_run run_;
    motion_recorder motion_;
    matrix6 from_robot_;
    bool has_wrench_;
};

} // namespace

stage_run play_stage(const rig &told, const rig &hardware, const std::string &log_path)
{
    refuse_unstable_steps(told);
    sim_options options;
    options.log_path = log_path;
    options.told = told;
    const auto app = std::make_unique<struct app>();
    const std::unique_ptr<struct hal, hal_status (*)(struct hal *)> open_hal(sim_open(hardware, options), hal_close);
    struct hal *hal = open_hal.get();
    app_start(app.get(), &told.firmware);
    manipulator_stand_in manipulator(hardware);
    stage_observer observer(told);
    while (app->supervisor.state != SUPERVISOR_STOPPED && loop_tick(hal, app.get()) == HAL_OK) {
        observer.note(*app, sim_rig(hal).truth().spring_force_N);
        manipulator.replace(*app);
    }
    sim_log(hal).drain();
    return observer.conclude();
}

stage_run read_stage(const std::string &log_path)
{
    ulog_reader log(log_path);
    const rig told = log.recorded_rig();
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &told.firmware);
    stage_observer observer(told);
    recorded_tick tick{};
    while (read_tick(log, tick)) {
        tick_output out;
        app_step(app.get(), &tick.in, &out);
        observer.note(*app, {});
    }
    return observer.conclude();
}

} // namespace berth
