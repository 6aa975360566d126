/* The firmware's own units as the controller: adaptive inverse on the motion side, force lead on the force side.
 * What they are told follows from the frame and the nominal hardware. */
#ifndef SIM_HAL_RTHS_FIRMWARE_CONTROLLER_H
#define SIM_HAL_RTHS_FIRMWARE_CONTROLLER_H

#include "../../firmware/compensation/adaptive_inverse.h"
#include "../../firmware/compensation/force_lead.h"
#include "controller.h"

namespace berth::rths
{

/* Coefficients of the nominal actuator with the specimen, inverted: command = sum of a_i x^(i), in s^i. */
using series = Eigen::Matrix<double, INVERSE_TERMS_MAX, 1>;
series inverse_of(const transfer_parameters &hardware);

class firmware_controller : public controller
{
  public:
    /* `leads`: else the frame gets the force as late as the benchmark has it. */
    firmware_controller(const known_beforehand &known, bool leads);

    controller_output step(const controller_input &input) override;

  private:
    series derivatives(const controller_input &input);

    bool leads_;
    adaptive_inverse inverse_;
    force_lead lead_;
    Eigen::Matrix<double, INVERSE_TERMS_MAX, 2 * floors> from_frame_;
    Eigen::Matrix<double, INVERSE_TERMS_MAX, 2> from_ground_; /* acceleration and its slope */
    double ground_before_m_per_s2_ = 0.0;
};

} // namespace berth::rths

#endif
