/* Tracks with models of both sides, from what is known beforehand and what the sensors tell:
 * - the simulated floor's derivatives up to the fifth are those of the whole structure in the frame's present state:
 *   if the hardware does what is simulated, both move as one. They are free of the sensors' noise;
 * - the nominal hardware, inverted exactly, gives the command and the hardware's states that go with them;
 * - a Kalman filter on the nominal hardware estimates its states, the error of the specimen's stiffness, and what is
 *   missing at the valve as if the command had an error: valve and leakage differ from the nominal ones;
 * - the frame is given the force that the filter predicts for the middle of its next step, not one that is late.
 * Fixed sizes, no heap after construction: it can move into the firmware. */
#ifndef SIM_HAL_RTHS_MODEL_CONTROLLER_H
#define SIM_HAL_RTHS_MODEL_CONTROLLER_H

#include "controller.h"

namespace berth::rths
{

struct model_settings {
    double effort = 1e-3;           /* price of a command's square beside that of the same motion's error */
    double command_walk_m = 1e-6;   /* of the command's error, in a sample */
    double stiffness_spread = 0.05; /* standard deviation of the specimen's stiffness, of the nominal one */
    double stiffness_walk = 1e-6;   /* in a sample */
    double state_walk = 1e-5;       /* of the hardware's states in a sample, of their usual size */
    /* The force that the frame gets is that of so long after now: 0.5 is the middle of the step for which it is
     * held, -1 as late as the benchmark's. */
    double force_lead_samples = 0.5;
};

class model_controller : public controller
{
  public:
    model_controller(const known_beforehand &known, const model_settings &settings);

    controller_output step(const controller_input &input) override;

  private:
    static constexpr int orders = 6; /* of the target and its derivatives */
    static constexpr int estimates = transfer_states + 2;
    static constexpr int command_error = transfer_states;       /* in m */
    static constexpr int stiffness_error = transfer_states + 1; /* of the nominal stiffness */
    using target = Eigen::Matrix<double, orders, 1>;
    using estimate = Eigen::Matrix<double, estimates, 1>;
    using estimate_matrix = Eigen::Matrix<double, estimates, estimates>;

    struct hardware_motion {
        transfer_state state;
        double command_m;
    };

    target derivatives(const controller_input &input);
    /* What the nominal hardware, with the stiffness as estimated, must be in and be told to move as `wanted`. */
    hardware_motion to_move_as(const target &wanted) const;
    void correct(double measured_m, double measured_N);
    void correct_by(int state, double innovation, double variance);
    void predict(double command_m);

    transfer_parameters nominal_;
    model_settings settings_;
    transfer_state size_; /* of the states, in their units: the filter computes in these */
    transfer_matrix dynamics_;
    transfer_state input_;
    transfer_state gain_; /* of the feedback, m per unit of the state */
    transfer_matrix transition_;
    transfer_state from_command_;
    transfer_state from_acceleration_; /* of the specimen */
    Eigen::Matrix<double, orders, 2 * floors> from_frame_;
    Eigen::Matrix<double, orders, 2> from_ground_; /* acceleration and its slope */
    estimate state_ = estimate::Zero();
    estimate_matrix covariance_ = estimate_matrix::Zero();
    double measured_before_m_ = 0.0;
    double command_before_m_ = 0.0;
    double ground_before_m_per_s2_ = 0.0;
};

} // namespace berth::rths

#endif
