/* The manipulator in steps, with effects on it: exact where it is linear, with operator and force held; further
 * forces act as they are in the middle of a step, which is a shorter one where dry friction may turn. */
#ifndef SIM_HAL_SOLVER_MANIPULATOR_STEPS_H
#define SIM_HAL_SOLVER_MANIPULATOR_STEPS_H

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "../../hal/rig/rig.h"
#include "../effects/stages.h"

namespace berth
{

inline constexpr int steps_with_effects = 8; /* a tick */

/* Of what a further force does, so much may be wrong by the steps. Of commands written to 1 nm, which a spring, play
 * or dampers moved by 0.2 to 10 mm, 3e-7 to 4e-6 were left. */
inline constexpr double steps_exact = 1e-5;

class manipulator_steps
{
  public:
    /* What acts on it over one tick. */
    struct input {
        double operator_position_m;
        double operator_velocity_m_per_s;
        double push_N; /* operator less measured force */
        double time_s;
    };

    /* With effects a period is divided into so many steps, or more where it oscillates fast. */
    manipulator_steps(const rig &rig, double period_s, int steps = steps_with_effects);

    bool has_effects() const { return !forces_.empty(); }
    void start(const Eigen::Vector2d &state); /* position in m, velocity in m/s */
    const Eigen::Vector2d &state() const { return state_; }
    void advance(const input &in);

  private:
    using step_map = Eigen::Matrix<double, 2, 5>; /* of (x, v, x_op, v_op, push) */

    /* What operator and force make of position and velocity over a step. */
    struct held {
        double way_m;
        double rate_m_per_s;
    };

    static held held_over(const step_map &map, const input &in);
    bool is_divided(const held &driven) const;
    void step(const step_map &map, double step_s, const held &driven, const input &in);

    std::vector<std::unique_ptr<force_stage>> forces_;
    double friction_N_;    /* dry */
    double turning_way_m_; /* over which it turns */
    int steps_;
    double step_s_;
    step_map map_;
    int turning_parts_; /* of one of the steps in which it may turn */
    step_map fine_map_; /* of such a part */
    Eigen::Vector2d state_ = Eigen::Vector2d::Zero();
};

} // namespace berth

#endif
