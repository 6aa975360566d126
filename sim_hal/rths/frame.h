/* A frame on moving ground: the reference structure, and the part of it that is simulated. */
#ifndef SIM_HAL_RTHS_FRAME_H
#define SIM_HAL_RTHS_FRAME_H

#include "building.h"
#include "transfer_system.h"

namespace berth::rths
{

using frame_state = Eigen::Matrix<double, 2 * floors, 1>; /* positions in m, then velocities in m/s, to the ground */
using frame_matrix = Eigen::Matrix<double, 2 * floors, 2 * floors>;

class frame
{
  public:
    /* The reference structure. */
    explicit frame(const building &all);

    /* Without the specimen at the first floor; the ground moves the mass of all of it. */
    frame(const building &all, const transfer_parameters &specimen);

    /* The hardware's force on the first floor is held for a sample; 0 for the reference structure. */
    void step(double time_s, const ground_motion &ground, double force_N);

    const frame_state &state() const { return state_; }
    double first_floor_acceleration_m_per_s2(double ground_m_per_s2, double force_N) const;

    /* state' = A state + b_g a_g + b_f f */
    const frame_matrix &dynamics() const { return dynamics_; }
    const frame_state &ground_input() const { return ground_input_; }
    const frame_state &force_input() const { return force_input_; }

  private:
    frame(const building &all, const building &simulated);

    frame_matrix dynamics_;
    frame_state ground_input_;
    frame_state force_input_;
    frame_state state_ = frame_state::Zero();
};

} // namespace berth::rths

#endif
