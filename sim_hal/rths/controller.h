/* What moves the actuator in the benchmark, and what the simulated frame is told of the hardware's force. */
#ifndef SIM_HAL_RTHS_CONTROLLER_H
#define SIM_HAL_RTHS_CONTROLLER_H

#include <memory>
#include <string>
#include <vector>

#include "frame.h"

namespace berth::rths
{

/* What is known at a sample, before the frame's next step. */
struct controller_input {
    double target_m; /* of the simulated first floor */
    double target_m_per_s;
    double target_m_per_s2;       /* under the force of the last sample */
    const frame_state &simulated; /* all of the frame */
    double ground_m_per_s2;
    double measured_m;
    double late_N; /* force measured at the sample before: what the benchmark gives to the frame */
};

struct controller_output {
    double command_m; /* to the actuator */
    double force_N;   /* to the simulated frame, held for a sample */
};

class controller
{
  public:
    virtual ~controller() = default;
    virtual controller_output step(const controller_input &input) = 0;
};

/* What a controller may know before the run: the frame and the nominal hardware, never the perturbed one. */
struct known_beforehand {
    building all;
    transfer_parameters nominal;
    double force_age_samples = 1.0; /* of late_N, as told */
};

std::vector<std::string> controller_names();

/* Throws input_error for an unknown name. */
std::unique_ptr<controller> make_controller(const std::string &name, const known_beforehand &known);

} // namespace berth::rths

#endif
