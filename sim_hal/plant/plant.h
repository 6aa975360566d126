/* The hardware as equations: robot transfer behaviour, sensor spring, object, force low-pass, and the effects that
 * are linear. Right-hand sides and parameters only; who integrates them, and what discrete things happen in between,
 * is told elsewhere.
 *
 *   reference line     u(t), straight between setpoints
 *   robot              p'' = w^2 (u - p) - 2 z w p'          (or p = u without transfer behaviour)
 *   its lag            tau_R r' = p - r                      (or r = p)
 *   sensor spring      F = k_S (r - g - x) + d_S (r' - x')   (or F = 0, while nothing is held)
 *   gripped object     m x'' = F - d x' - k x + C
 *   tool in contact    m x'' = F - max(0, k (x - s) + d x') + C where x > s, else m x'' = F + C
 *   beam               x = q1 + q2 + ...; m_i q_i'' = F - d_i q_i' - k_i q_i, the first with m, d and k
 *   mass that hangs on it  m2 x2'' = -C = -m2 (w2^2 (x2 - x) + 2 z2 w2 (x2' - x'))   (or C = 0)
 *   what relaxes beside its spring  z = k_R (x - x_R), tau_X x_R' = x - x_R, also against x   (or z = 0)
 *   force low-pass     y'' = w_L^2 (F + m_T r'' - y) - 2 z_L w_L y'    (order 2; m_T: tool behind the sensor)
 *                      y'  = w_L (F - y)                     (order 1)
 *                      y   = F                               (order 0)
 *   sensor's lag       tau_S s' = y - s                      (or s = y)
 */
#ifndef SIM_HAL_PLANT_PLANT_H
#define SIM_HAL_PLANT_PLANT_H

#include <algorithm>
#include <cstdint>
#include <Eigen/Core>

#include "../../hal/rig/rig.h"

namespace berth
{

/* Places in the state, in pairs. What a rig does not have is unused and stays 0. */
enum plant_index {
    object_position, /* x, m */
    object_velocity, /* x', m/s */
    filter_output,   /* y, N */
    filter_rate,     /* y' less w_L^2 m_T r', which may jump, N/s; order 2 */
    robot_position,  /* p, m */
    robot_velocity,  /* p', m/s */
    second_position, /* x2, m */
    second_velocity, /* x2', m/s */
    lagged_position, /* r, m */
    no_state_behind_lagged_position,
    lagged_force, /* s, N */
    no_state_behind_lagged_force,
    relaxed_position,               /* x_R, m */
    fading_behind_relaxed_position, /* makes a pair of it: nothing drives it, and it drives nothing */
    plant_state_count
};

using plant_state = Eigen::Matrix<double, plant_state_count, 1>;

/* The same and, behind it, q_i and q_i' of a beam's further modes: x stays what the gripper feels, and the first
 * mode is what is left of it. */
constexpr int beam_state_count = plant_state_count + 2 * (beam_modes_max - 1);
using beam_state = Eigen::Matrix<double, beam_state_count, 1>;

/* Place of the position of a further mode, counted from 0. */
constexpr Eigen::Index further_position(Eigen::Index i)
{
    return plant_state_count + 2 * i;
}

template <typename state_type>
constexpr bool has_room_for_beam = state_type::RowsAtCompileTime == beam_state_count;

/* A straight line: position_m at the start of the interval, then with velocity_m_per_s. */
struct reference_line {
    double position_m = 0.0;
    double velocity_m_per_s = 0.0;
};

/* Whether the tool touches the material; a gripped object is always attached. */
enum class contact_mode { free, attached };

struct plant {
    explicit plant(const rig &rig);

    bool has_transfer_behaviour;
    double robot_w = 0.0; /* rad/s */
    double robot_z = 0.0;
    double sensor_stiffness_N_per_m;
    double sensor_damping_N_s_per_m;
    bool is_held = true; /* by the gripper; else there is no sensor spring */
    double grip_m = 0.0; /* g: robot less object where neither pulls the other */
    bool one_sided;
    double mass_kg;
    double stiffness_N_per_m;
    double damping_N_s_per_m;
    double surface_m = 0.0;
    std::int64_t filter_order;
    double filter_w = 0.0; /* rad/s */
    double filter_z = 0.0;
    double robot_lag_s;
    double sensor_lag_s;
    double second_mass_kg;
    double second_w; /* rad/s */
    double second_z;
    double tool_mass_kg;
    double relaxation_N_per_m;
    double relaxation_s;

    struct further_mode {
        double mass_kg;
        double damping_N_s_per_m;
        double stiffness_N_per_m;
    };
    std::array<further_mode, beam_modes_max - 1> further_modes{};
    int further_mode_count = 0;

    bool has_linear_effects() const
    {
        return robot_lag_s > 0.0 || sensor_lag_s > 0.0 || second_mass_kg > 0.0 || tool_mass_kg > 0.0 ||
               relaxation_N_per_m > 0.0;
    }

    /* The robot is where it is told to be, the force as it leaves the low-pass, the object alone. */
    void leave_out_linear_effects() { robot_lag_s = sensor_lag_s = second_mass_kg = relaxation_N_per_m = 0.0; }

    /* States in use of a beam_state: what a rig without further modes has, or those as well. */
    int state_count() const { return plant_state_count + 2 * further_mode_count; }

    /* What follows takes a plant_state, where there are no further modes, or a beam_state. */

    /* What each state reaches where the object swings by 1 m on the sensor spring: units in which the equations are
     * of one size. */
    template <typename state_type>
    state_type natural_scales() const;

    /* Everything at rest with the robot at `position_m`, spring forces in balance, low-pass settled; the object at
     * its own place where it is not held. */
    template <typename state_type>
    state_type at_rest(double position_m) const;

    /* Robot position (m) and velocity (m/s) in a state, the reference being on `line`. */
    template <typename state_type>
    double robot_position_m(const state_type &state, const reference_line &line) const;
    template <typename state_type>
    double robot_velocity_m_per_s(const state_type &state, const reference_line &line) const;

    /* F, N, before the low-pass. */
    template <typename state_type>
    double spring_force_N(const state_type &state, const reference_line &line) const;

    /* C, N. */
    template <typename state_type>
    double second_force_N(const state_type &state) const;

    /* s, N: what the sensor samples. */
    template <typename state_type>
    double measured_force_N(const state_type &state, const reference_line &line) const;

    /* Force of the elastic material or of the object's spring and damper on the mass, N; never pulls if one-sided.
     */
    template <typename state_type>
    double object_force_N(const state_type &state) const;

    template <typename state_type>
    contact_mode mode(const state_type &state) const
    {
        return !one_sided || object_force_N(state) > 0.0 ? contact_mode::attached : contact_mode::free;
    }

    /* d(state)/dt with the reference on `line`. */
    template <typename state_type>
    state_type derivative(const state_type &state, const reference_line &line) const;

    /* The reference jumps by `jump_m` ("hold"): without transfer behaviour and lag the sensor's damper makes an
     * impulse of it, d_S jump, which changes the object's velocity and the low-pass at once. */
    template <typename state_type>
    void apply_reference_jump(state_type &state, double jump_m) const;

  private:
    template <typename state_type>
    void add_linear_effects(state_type &rate, const state_type &state, const reference_line &line,
                            double force_N) const;
    void add_further_modes(beam_state &rate, const beam_state &state, double force_N) const;
};

/* Inline, so that only what differs from 0 is left where they are asked for unit vectors. */

template <typename state_type>
double plant::robot_position_m(const state_type &state, const reference_line &line) const
{
    return robot_lag_s > 0.0        ? state(lagged_position)
           : has_transfer_behaviour ? state(robot_position)
                                    : line.position_m;
}

template <typename state_type>
double plant::robot_velocity_m_per_s(const state_type &state, const reference_line &line) const
{
    if (robot_lag_s > 0.0) {
        const double goal_m = has_transfer_behaviour ? state(robot_position) : line.position_m;
        return (goal_m - state(lagged_position)) / robot_lag_s;
    }
    return has_transfer_behaviour ? state(robot_velocity) : line.velocity_m_per_s;
}

template <typename state_type>
double plant::spring_force_N(const state_type &state, const reference_line &line) const
{
    if (!is_held) {
        return 0.0;
    }
    return sensor_stiffness_N_per_m * (robot_position_m(state, line) - grip_m - state(object_position)) +
           sensor_damping_N_s_per_m * (robot_velocity_m_per_s(state, line) - state(object_velocity));
}

template <typename state_type>
double plant::measured_force_N(const state_type &state, const reference_line &line) const
{
    return sensor_lag_s > 0.0 ? state(lagged_force)
           : filter_order > 0 ? state(filter_output)
                              : spring_force_N(state, line);
}

template <typename state_type>
double plant::second_force_N(const state_type &state) const
{
    return second_mass_kg * (second_w * second_w * (state(second_position) - state(object_position)) +
                             2.0 * second_z * second_w * (state(second_velocity) - state(object_velocity)));
}

template <typename state_type>
double plant::object_force_N(const state_type &state) const
{
    const double depth_m = state(object_position) - surface_m;
    const double force_N = stiffness_N_per_m * depth_m + damping_N_s_per_m * state(object_velocity);
    return !one_sided ? force_N : depth_m > 0.0 ? std::max(0.0, force_N) : 0.0;
}

template <typename state_type>
state_type plant::derivative(const state_type &state, const reference_line &line) const
{
    const double force_N = spring_force_N(state, line);
    state_type rate = state_type::Zero();
    rate(object_position) = state(object_velocity);
    rate(object_velocity) = (force_N - object_force_N(state)) / mass_kg;
    if (filter_order == 2) {
        rate(filter_output) = state(filter_rate);
        rate(filter_rate) =
            filter_w * filter_w * (force_N - state(filter_output)) - 2.0 * filter_z * filter_w * state(filter_rate);
    } else if (filter_order == 1) {
        rate(filter_output) = filter_w * (force_N - state(filter_output));
    }
    if (has_transfer_behaviour) {
        rate(robot_position) = state(robot_velocity);
        rate(robot_velocity) = robot_w * robot_w * (line.position_m - state(robot_position)) -
                               2.0 * robot_z * robot_w * state(robot_velocity);
    }
    if (has_linear_effects()) {
        add_linear_effects(rate, state, line, force_N);
    }
    if constexpr (has_room_for_beam<state_type>) {
        if (further_mode_count > 0) {
            add_further_modes(rate, state, force_N);
        }
    }
    return rate;
}

} // namespace berth

#endif
