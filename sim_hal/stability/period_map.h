/* The loop over one period as a matrix: the state just before tick n+1 from that just before tick n. It is put
 * together from what runs: the firmware's manipulator step, compensation and inverse filter, and the exact solver's
 * transitions of the plant. Rounding on the wire, limits, losses, noise and jitter are left out. */
#ifndef SIM_HAL_STABILITY_PERIOD_MAP_H
#define SIM_HAL_STABILITY_PERIOD_MAP_H

#include <Eigen/Core>

#include "../../firmware/inverse_filter.h"
#include "../../firmware/manipulator.h"
#include "compensation_states.h"
#include "hardware_period.h"

namespace berth
{

/* Places of the blocks in the state. */
struct period_layout {
    Eigen::Index manipulator = 0; /* x, v */
    Eigen::Index filter;          /* u[n-1], u[n-2], y[n-1], y[n-2]; none if not enabled */
    Eigen::Index plant;           /* those in use, see hardware_period::state() */
    Eigen::Index setpoints;       /* newest first: those sent before that the robot still needs */
    Eigen::Index samples;         /* newest first: those taken that have not been used */
    Eigen::Index compensation;    /* see compensation_states; none if none is on */
    Eigen::Index count;
};

class period_map
{
  public:
    /* Throws input_error for rigs without one linear map: contact, free robot clock, passivity controller. */
    explicit period_map(const rig &rig);
    period_map(const period_map &) = delete; /* parts of it point at others */
    period_map &operator=(const period_map &) = delete;

    const period_layout &layout() const { return layout_; }

    /* One period ahead. */
    Eigen::VectorXd advance(const Eigen::VectorXd &state) const;

    /* advance() as a matrix. */
    Eigen::MatrixXd matrix() const;

    double period_s() const { return period_s_; }

  private:
    void lay_out();

    hardware_period hardware_;
    app_config firmware_;
    manipulator manipulator_;
    inverse_filter filter_;
    compensation_states compensation_;
    period_layout layout_{};
    Eigen::Index history_; /* setpoints before this tick's that still matter */
    double period_s_;
};

} // namespace berth

#endif
