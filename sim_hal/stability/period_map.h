/* The loop over one period as a matrix: the state just before tick n+1 from that just before tick n. It is put
 * together from what runs: the firmware's manipulator step and inverse filter, and the exact solver's transitions
 * of the plant. Rounding on the wire, limits, losses, noise and jitter are left out. */
#ifndef SIM_HAL_STABILITY_PERIOD_MAP_H
#define SIM_HAL_STABILITY_PERIOD_MAP_H

#include <Eigen/Core>
#include <vector>

#include "../../firmware/inverse_filter.h"
#include "../../firmware/manipulator.h"
#include "../plant/plant.h"

namespace berth {

/* Places of the blocks in the state. */
struct period_layout {
    Eigen::Index manipulator = 0; /* x, v */
    Eigen::Index filter;          /* u[n-1], u[n-2], y[n-1], y[n-2]; none if not enabled */
    Eigen::Index plant;           /* the plant's states that are in use, see plant_index */
    Eigen::Index setpoints;       /* newest first: those sent before that the robot still needs */
    Eigen::Index samples;         /* newest first: those taken that have not been used */
    Eigen::Index count;
};

class period_map {
public:
    /* Throws input_error for rigs without one linear map: contact, free robot clock. */
    explicit period_map(const rig &rig);

    const period_layout &layout() const { return layout_; }

    /* One period ahead. */
    Eigen::VectorXd advance(const Eigen::VectorXd &state) const;

    /* advance() as a matrix. */
    Eigen::MatrixXd matrix() const;

    double period_s() const { return period_s_; }

private:
    /* Transition of (state, u, u') over a part of the period. */
    struct part {
        std::int64_t from_ns;
        std::int64_t to_ns;
        Eigen::Matrix<double, plant_state_count, plant_state_count + 2> transition;
    };
    void add_part(const Eigen::MatrixXd &generator, std::int64_t from_ns, std::int64_t to_ns);
    void lay_out();
    reference_line line_at(const Eigen::VectorXd &setpoints, std::int64_t offset_ns, bool after_knot) const;

    plant plant_;
    app_config firmware_;
    manipulator manipulator_;
    inverse_filter filter_;
    period_layout layout_{};
    std::vector<Eigen::Index> plant_states_; /* in use, as plant_index */
    std::int64_t period_ns_;
    double period_s_;
    bool holds_;
    std::int64_t whole_dead_periods_; /* of T_R */
    Eigen::Index history_;            /* setpoints before this tick's that still matter */
    std::int64_t knot_ns_;            /* what is left of T_R: offset of the reference's knot in the period */
    std::int64_t sample_ns_;          /* offset of the sample in the period */
    std::int64_t sample_age_ticks_;   /* F[n] is the sample taken in period n - this */
    bool samples_before_knot_;
    std::vector<part> parts_;
};

} // namespace berth

#endif
