/* Moments that decide all that follows, found anew: a grip by bisection, lost setpoints by replays. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../sim_hal/diagnosis/fit/grip_bisection.h"
#include "../../sim_hal/diagnosis/replay/driven_path.h"
#include "../../sim_hal/diagnosis/samples/loss_polisher.h"
#include "hal/rig/rig_file.h"

using namespace berth;

namespace
{

/* A motion that grows. */
record growing(const rig &rig)
{
    record made;
    made.period_s = config_period_s(&rig.firmware);
    for (int n = 0; n < 4000; n++) {
        const double t_s = made.period_s * n;
        made.time_s.push_back(t_s);
        made.command_position_m.push_back(1e-3 * t_s * (std::sin(4.0 * t_s) + 0.4 * std::sin(11.0 * t_s)));
    }
    made.segments.push_back({0, made.time_s.size(), {}});
    return made;
}

/* Measured by a rig, of which `error` is the error of nothing. */
std::vector<double> measured_by(block which, const rig &rig, record &made, const sample_events &events)
{
    (which == block::force ? made.force_N : made.robot_position_m).assign(made.size(), 0.0);
    block_model model(which, made, rig, events, held_out_parts::none);
    std::vector<double> values;
    model.error(rig, values);
    for (double &value : values) {
        value = -value;
    }
    return values;
}

double squares_of(const std::vector<double> &values)
{
    double sum = 0.0;
    for (const double value : values) {
        sum += value * value;
    }
    return sum;
}

} // namespace

TEST_CASE("grip: the first moment that is wrong says whether it is too strong or too weak")
{
    for (const double grip_N : {3.0, 8.0, 21.0}) {
        CAPTURE(grip_N);
        rig truth = load_rig("ess", {});
        set_number(truth, "object.grip_force_N", grip_N);
        record made = growing(truth);
        const sample_events none;
        made.force_N = measured_by(block::force, truth, made, none);
        const double most_N = -2.0 * *std::min_element(made.force_N.begin(), made.force_N.end());
        REQUIRE(most_N > grip_N);
        block_model model(block::force, made, truth, none, held_out_parts::none);
        const noise_model noise{{}, 1e-4, 1e-4, 1.0};
        const rig found = with_bisected_grip(model, noise, load_rig("ess", {}), "object.grip_force_N", most_N);
        CHECK(value_of(found, "object.grip_force_N") == doctest::Approx(grip_N).epsilon(1e-3));
        std::vector<double> error;
        model.error(found, error);
        CHECK(std::sqrt(squares_of(error) / static_cast<double>(error.size())) < 2e-3);
    }
}

TEST_CASE("lost setpoints: replays put right what is one off")
{
    const rig rig = load_rig("ess", {"robot.dead_time_ms=10", "robot.backlash_m=1e-3"});
    record made = growing(rig);
    sample_events truth;
    for (std::size_t n = 0; n < made.size(); n++) {
        truth.lost_command.push_back(n > 0 && n % 29 == 7);
    }
    made.robot_position_m = measured_by(block::robot, rig, made, truth);
    /* Those that would show. */
    const std::vector<double> at_stake_m = way_at_stake_m(rig, made, truth.lost_command);
    sample_events told = truth;
    std::size_t wrong = 0;
    for (std::size_t n = 1000; n + 100 < made.size() && wrong < 5; n++) {
        if (truth.lost_command[n] != 0 && at_stake_m[n] > 2e-5) {
            told.lost_command[n] = 0;
            told.lost_command[n + 1] = wrong % 2; /* a tick late, or not at all */
            wrong++;
            n += 200;
        }
    }
    REQUIRE(wrong == 5);
    block_model model(block::robot, made, rig, told, held_out_parts::none);
    std::vector<double> error;
    model.error(rig, error);
    REQUIRE(squares_of(error) > 5 * 4e-10);
    polish_losses(model, rig, trace_of_loss(model, rig), 20.0, told);
    model.forget_motion();
    model.error(rig, error);
    CHECK(squares_of(error) < 1e-20);
    for (std::size_t n = 0; n < made.size(); n++) {
        CHECK((told.lost_command[n] == truth.lost_command[n] || at_stake_m[n] < 1e-9));
    }
}
