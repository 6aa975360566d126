/* The blocks of the loop, each driven by what was recorded at its input: so an error is found where it arises, and
 * stays there. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_REPLAY_H
#define SIM_HAL_DIAGNOSIS_REPLAY_REPLAY_H

#include <cstdint>
#include <Eigen/Core>
#include <vector>

#include "../../../hal/rig/rig.h"
#include "../record/record.h"

namespace berth
{

/* What happened to single samples, by row of the record; empty: nothing did. */
struct sample_events {
    std::vector<std::uint8_t> lost_command;  /* the setpoint of this row did not reach the robot */
    std::vector<std::uint8_t> loss_shows;    /* had it not, a block that was looked at would show it */
    std::vector<std::uint8_t> robot_repeats; /* the robot's position is that of the row before */
    std::vector<std::uint8_t> force_repeats;
    std::vector<std::uint8_t> spike; /* the force of this row is not one */
};

struct events_of_records {
    sample_events fit;
    sample_events unseen; /* of the validation record */
};

/* A tick in steps. Steps end at the knots of the reference and at the force sample, so that the reference is
 * straight within a step and nothing has to be interpolated. */
struct tick_steps {
    std::vector<double> duration_s; /* of each step */
    std::vector<std::size_t> kind;  /* steps of one length have one kind */
    std::size_t kinds = 0;
    std::size_t sample_after = 0;  /* the force is sampled after so many steps */
    std::ptrdiff_t ticks_late = 0; /* and used so many ticks after the one that it falls into */

    std::size_t count() const { return duration_s.size(); }
};

/* `steps_min`: a tick has at least so many; `rig.sensor.delay_ms` is the age of the force, see sample_age.h. */
tick_steps divide_tick(const rig &rig, double period_s, int steps_min);

/* The robot's position over time. */
struct robot_motion {
    tick_steps tick;
    std::vector<double> position_m; /* at the ends of steps; the first of a segment at its start */
    std::vector<double> bulge_m;    /* of the step before each position, see robot_way; empty: steps are straight */
    std::vector<double> at_tick_m;  /* one a row */
};

/* What a motion is for: the positions at the ticks alone, or those of all steps as well. */
enum class motion_detail { at_ticks, way };

/* Setpoints to motion: setpoint effects, dead time and interpolation, transfer behaviour, motion effects. A tick
 * has at least `steps_min` steps. */
void replay_robot(const rig &rig, const record &record, const sample_events &events, motion_detail detail,
                  int steps_min, robot_motion &motion);

/* Motion to force samples, N, one a row. */
void replay_force(const rig &rig, const record &record, const robot_motion &motion, std::vector<double> &force_N);

/* Position in m and velocity in m/s at the start of each window, from a parabola through its first rows. */
std::vector<Eigen::Vector2d> starts_of_windows(const record &record, const std::vector<record_segment> &windows);

/* Operator and measured force to the position of the manipulator, m, one a row; each window starts anew. */
void replay_manipulator(const rig &rig, const record &record, const std::vector<record_segment> &windows,
                        const std::vector<Eigen::Vector2d> &starts, std::vector<double> &position_m);

} // namespace berth

#endif
