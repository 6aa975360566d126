/* The plant with effects of the library in it, in short steps: the same stages and the same steps that a diagnosis
 * replays a record with. */
#ifndef SIM_HAL_SOLVER_EFFECT_SOLVER_H
#define SIM_HAL_SOLVER_EFFECT_SOLVER_H

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "../effects/robot_drive.h"
#include "object_steps.h"

namespace berth
{

class effect_solver
{
  public:
    /* At rest with the reference at `reference_m`. */
    effect_solver(const rig &rig, double reference_m);

    /* Advances by `duration_ns`; `line` is the reference, its position that at the start. */
    void advance(const reference_line &line, std::int64_t duration_ns);

    /* The reference jumps to `reference_m`. */
    void jump(double reference_m) { object_.jump(drive_.jump(reference_m)); }

    double robot_position_m() const { return object_.robot_line().position_m; }
    double robot_velocity_m_per_s() const { return object_.robot_line().velocity_m_per_s; }
    double spring_force_N() const { return object_.spring_N(); }
    double measured_force_N() const { return force_N_; }

    /* Object, low-pass and robot, as plant_index. */
    beam_state state() const;
    void set_state(const beam_state &state); /* of object and low-pass; the robot stays where it is */

  private:
    struct known_step {
        std::int64_t duration_ns = -1;
        object_steps::step_maps maps;
        object_steps::step_maps fine;
    };

    void step(double reference_m, std::int64_t duration_ns);
    const known_step &maps_for(std::int64_t duration_ns);

    robot_drive drive_;
    object_steps object_;
    std::vector<std::unique_ptr<motion_stage>> filters_;
    std::int64_t step_max_ns_;
    std::int64_t now_ns_ = 0;
    double force_N_ = 0.0;

    std::array<known_step, 32> known_; /* a regular run has few durations */
    std::size_t next_known_ = 0;
};

} // namespace berth

#endif
