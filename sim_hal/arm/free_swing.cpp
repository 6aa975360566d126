#include "free_swing.h"

#include <cmath>

#include "../../firmware/pi.h"
#include "../solver/ode.h"
#include "swinging_arm.h"

namespace berth
{

namespace
{

constexpr double solver_tolerance = 1e-10; /* of the solver, against the deflection */
constexpr int turning_points = 4;          /* after the first: two swings */
constexpr int looks = 400;                 /* in the longest half of a swing: how often limits are looked at */
constexpr double turning_share = 0.02;     /* of the small swing's period, in which it does not turn twice */
constexpr long steps_max = 50000;          /* of the solver from turning point to turning point */
constexpr double uneven_share = 0.5;       /* of the mean decrement: by how much each may be off it */
constexpr double uneven_rounding = 1e-4;
constexpr double slowest_share = 0.1; /* of the small swing's frequency: what is slower counts as no swing */

/* From turning point to turning point. */
struct half_swings {
    double duration_s = 0.0; /* of all */
    double height_m[turning_points] = {};
};

/* From one side. Nothing where it does not swing so far; throws not_solved where it takes too many steps. */
template <class Space>
std::optional<half_swings> follow(const swinging_arm<Space> &arm, const coupled_mode &mode, double amplitude_m,
                                  limits_met &limits)
{
    const std::optional<Eigen::VectorXd> start = arm.deflected(mode, amplitude_m);
    if (!start) {
        return {};
    }
    ode equations;
    equations.rate = [&](double, const Eigen::VectorXd &at) { return arm.rate(at); };
    equations.steps_max = steps_max;
    const Eigen::VectorXd tolerances =
        Eigen::VectorXd::Constant(arm.states(), solver_tolerance * std::fabs(amplitude_m));
    ode_solver away(equations, solver_tolerance,
                    tolerances); /* from a turning point, which is none that is looked for */
    equations.event = [&](double, const Eigen::VectorXd &at) { return arm.velocity_m_per_s(at); };
    ode_solver to_next(equations, solver_tolerance, tolerances);
    const double small_period_s = 1.0 / mode.frequency_Hz();
    const double longest_s = small_period_s / slowest_share;
    Eigen::VectorXd at = *start;
    half_swings found;
    double way_m = arm.way_m(at);
    arm.note_limits(at, limits);
    for (double &height_m : found.height_m) {
        const double from_s = found.duration_s;
        const double until_s = from_s + longest_s;
        std::vector<double> looks_s;
        for (int look = 1; look < looks; look++) {
            looks_s.push_back(from_s + look * (longest_s / looks));
        }
        const double on_the_way_s = away.advance(at, from_s, from_s + turning_share * small_period_s);
        found.duration_s =
            to_next.advance(at, on_the_way_s, until_s, looks_s,
                            [&](double, const Eigen::VectorXd &values) { arm.note_limits(values, limits); });
        if (!(found.duration_s < until_s) || !at.allFinite()) {
            return {};
        }
        const double next_m = arm.way_m(at);
        height_m = std::fabs(next_m - way_m);
        way_m = next_m;
    }
    return found;
}

/* One mode's half swings shrink by the same factor each. What a limit does to them changes that little by little;
 * where another mode takes part, energy goes to it and comes back. */
bool shrinks_evenly(const half_swings &found)
{
    const double *height_m = found.height_m;
    const double mean = std::log(height_m[0] / height_m[turning_points - 1]) / (turning_points - 1);
    for (int i = 1; i < turning_points; i++) {
        const double one = std::log(height_m[i - 1] / height_m[i]);
        if (!(std::fabs(one - mean) <= uneven_share * mean + uneven_rounding)) {
            return false;
        }
    }
    return true;
}

template <class Space>
free_swing both_sides(const arm_config &config, const reduction_choice &choice, const std::vector<beam_mode> &object,
                      const coupled_mode &mode, double amplitude_m)
{
    const swinging_arm<Space> arm(config, choice, object);
    free_swing result;
    double frequency_Hz = 0.0;
    double damping_ratio = 0.0;
    bool is_even = true;
    for (const double side_m : {amplitude_m, -amplitude_m}) {
        std::optional<half_swings> found;
        try {
            found = follow(arm, mode, side_m, result.limits);
        } catch (const not_solved &error) {
            result.not_measured = std::string("not followed: ") + error.what();
            return result;
        }
        if (!found) {
            result.not_measured = "does not swing so far";
            return result;
        }
        const double decrement = /* over a swing */
            2.0 / (turning_points - 1) * std::log(found->height_m[0] / found->height_m[turning_points - 1]);
        frequency_Hz += 0.5 * (0.5 * turning_points / found->duration_s);
        damping_ratio += 0.5 * (decrement / std::hypot(decrement, two_pi));
        is_even = is_even && shrinks_evenly(*found);
    }
    result.frequency_Hz = frequency_Hz;
    if (is_even) {
        result.damping_ratio = damping_ratio;
    } else {
        result.not_measured = "no measure: energy goes between modes";
    }
    return result;
}

} // namespace

free_swing swing_from(const arm_config &config, const reduction_choice &choice, const std::vector<beam_mode> &object,
                      const coupled_mode &mode, double amplitude_m)
{
    return config.kind == ARM_PLANAR ? both_sides<plane>(config, choice, object, mode, amplitude_m)
                                     : both_sides<space>(config, choice, object, mode, amplitude_m);
}

} // namespace berth
