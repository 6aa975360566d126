#include "frame.h"

#include <Eigen/Core>

#include "../solver/factors.h"
#include "runge_kutta.h"

namespace berth::rths
{

namespace
{

building without_specimen(building all, const transfer_parameters &specimen)
{
    all.mass_kg(0, 0) -= specimen.specimen_mass_kg;
    all.damping_N_s_per_m(0, 0) -= specimen.specimen_damping_N_s_per_m();
    all.stiffness_N_per_m(0, 0) -= specimen.specimen_stiffness_N_per_m;
    return all;
}

} // namespace

frame::frame(const building &all) : frame(all, all) {}

frame::frame(const building &all, const transfer_parameters &specimen) : frame(all, without_specimen(all, specimen))
{
}

frame::frame(const building &all, const building &simulated)
{
    const floor_matrix mobility_per_kg = inverse(simulated.mass_kg);
    dynamics_ << floor_matrix::Zero(), floor_matrix::Identity(), -mobility_per_kg * simulated.stiffness_N_per_m,
        -mobility_per_kg * simulated.damping_N_s_per_m;
    ground_input_ << per_floor::Zero(), -mobility_per_kg * all.mass_kg * per_floor::Ones();
    force_input_ << per_floor::Zero(), -mobility_per_kg.col(0);
}

void frame::step(double time_s, const ground_motion &ground, double force_N)
{
    state_ = runge_kutta_step(state_, period_s, [&](const frame_state &state, double since_s) -> frame_state {
        return dynamics_ * state + ground_input_ * ground.at(time_s + since_s) + force_input_ * force_N;
    });
}

double frame::first_floor_acceleration_m_per_s2(double ground_m_per_s2, double force_N) const
{
    return dynamics_.row(floors).dot(state_) + ground_input_(floors) * ground_m_per_s2 +
           force_input_(floors) * force_N;
}

} // namespace berth::rths
