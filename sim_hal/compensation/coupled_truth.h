/* What hardware and simulated manipulator would do if nothing came late: the two as one system, the sensor spring
 * between them, without robot, low-pass and dead time, until the object is let go. What fidelity is measured
 * against. */
#ifndef SIM_HAL_COMPENSATION_COUPLED_TRUTH_H
#define SIM_HAL_COMPENSATION_COUPLED_TRUTH_H

#include "../../firmware/operator_command.h"
#include "../plant/plant.h"

namespace berth
{

class coupled_truth
{
  public:
    /* Effects other than a second mass on the object are left out. */
    explicit coupled_truth(const rig &rig);

    /* The manipulator is there, with that velocity; the object at rest with it. */
    void start(double position_m, double velocity_m_per_s, double time_s = 0.0);

    /* One period of the loop ahead, the command held. */
    void advance(const operator_command &command);

    double position_m() const { return arm_(0); }
    double velocity_m_per_s() const { return arm_(1); }

  private:
    struct rates {
        Eigen::Vector2d arm;
        plant_state hardware;
    };
    rates rates_at(const Eigen::Vector2d &arm, const plant_state &hardware, const operator_command &command) const;
    void step(const operator_command &command);
    void step_through(const operator_command &command);
    void find_tick();
    void let_go();

    using tick_map = Eigen::Matrix<double, 2 + plant_state_count, 2 + plant_state_count + 4>;

    plant plant_;
    manipulator_config manipulator_;
    double period_s_;
    double step_s_;
    double time_s_ = 0.0;
    double grip_release_s_;
    int steps_;
    tick_map tick_; /* (arm, hardware, command, 1) to (arm, hardware): a gripped object is linear */
    Eigen::Vector2d arm_ = Eigen::Vector2d::Zero();
    plant_state hardware_ = plant_state::Zero();
};

} // namespace berth

#endif
