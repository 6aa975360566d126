#include "manipulator_stand_in.h"

namespace berth
{

void manipulator_stand_in::replace(app &app)
{
    if (!steps_.has_effects()) {
        return;
    }
    const bool is_running = supervisor_may_move(&app.supervisor) != 0;
    const tick_record &record = app.recorder.tick;
    if (is_running) {
        if (!was_running_) {
            steps_.start({record.manipulator_position_m, record.manipulator_velocity_m_per_s});
        }
        steps_.advance({record.operator_position_m, record.operator_velocity_m_per_s,
                        record.operator_force_N - record.used_force_N,
                        1e-9 * static_cast<double>(record.scheduled_ns)});
        app.manipulator.position_m = steps_.state()(0);
        app.manipulator.velocity_m_per_s = steps_.state()(1);
    }
    was_running_ = is_running;
}

} // namespace berth
