/* What the beginning of a record rules out against the whole record. */
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/diagnosis/fit/base.h"
#include "../../sim_hal/diagnosis/fit/beginning.h"
#include "../../sim_hal/diagnosis/search/search.h"
#include "../unit/seeded.h"

using namespace berth;

namespace
{

constexpr double worth = 10.0;

double noise_sigma(block of)
{
    return of == block::force ? 0.2 : 5e-6;
}

/* 24 s of three sines, as the rig itself answers to them, with white noise. */
record record_of(const rig &rig, seeded::engine &random)
{
    record made;
    made.period_s = config_period_s(&rig.firmware);
    const auto rows = static_cast<std::size_t>(24.0 / made.period_s);
    made.segments = {{0, rows}};
    for (std::size_t n = 0; n < rows; n++) {
        const double t_s = made.period_s * static_cast<double>(n);
        made.time_s.push_back(t_s);
        made.command_position_m.push_back(6e-3 * std::sin(2.0 * t_s) + 3e-3 * std::sin(5.3 * t_s) +
                                          1e-3 * std::sin(11.0 * t_s));
    }
    robot_motion motion;
    replay_robot(rig, made, {}, motion_detail::way, 1, motion);
    replay_force(rig, made, motion, made.force_N);
    made.robot_position_m = motion.at_tick_m;
    const auto white = [&] { /* of variance 1 */
                             double sum = -6.0;
                             for (int i = 0; i < 12; i++) {
                                 sum += seeded::uniform(random, 0.0, 1.0);
                             }
                             return sum;
    };
    for (std::size_t n = 0; n < rows; n++) {
        made.force_N[n] += noise_sigma(block::force) * white();
        made.robot_position_m[n] += noise_sigma(block::robot) * white();
    }
    return made;
}

struct count {
    int starts = 0;
    int ruled_out = 0;
    int wrongly = 0;
    int grips_ruled_out = 0;
};

/* Of all starts in the library for this block. */
count compare(block of, const record &data, const rig &given)
{
    const sample_events events;
    block_model model(of, data, given, events, held_out_parts::two_tenths);
    noise_model noise;
    noise.sigma = noise.rms = noise_sigma(of);
    const fit_result incumbent = fit(model, noise, given, base_parameters(of, given), 60);
    const Eigen::VectorXd here = white_error(model, noise, incumbent.rig);
    const known_slopes slopes = slopes_at(model, noise, incumbent, here);
    const tangent_space base(incumbent, slopes);
    const tangent_space::target target = base.target_of(here);
    beginning first(model, noise, incumbent, slopes, here);
    std::vector<double> error;
    model.error(incumbent.rig, error);
    const record_scales scales = scales_of(model, incumbent.rig, error);
    count made;
    for (const effect *const effect : effects_to_try(model, given, {}, {})) {
        for (const effect_values &values : effect->starts(incumbent.rig, scales)) {
            const rig start = with_values(incumbent.rig, *effect, values);
            const bool is_ruled_out = first.rules_out(start, 0.1, 3.0, worth);
            const Eigen::VectorXd change = white_error(model, noise, start) - here;
            const double decrease = base.best_share(target, change, 0.1, 3.0).decrease;
            CAPTURE(effect->name);
            CAPTURE(values[0]);
            CHECK((!is_ruled_out || decrease < worth));
            made.starts++;
            made.ruled_out += is_ruled_out ? 1 : 0;
            made.wrongly += is_ruled_out && !(decrease < worth) ? 1 : 0;
            made.grips_ruled_out += is_ruled_out && effect->name == "object.loss_of_contact" ? 1 : 0;
        }
    }
    return made;
}

} // namespace

TEST_CASE("beginning of a record: what it rules out promises nothing on the whole of it")
{
    SEEDED(random, "beginning of a record*");
    const rig given = load_rig("ess", {});
    for (const char *const hidden :
         {"robot.backlash_m=0", "robot.backlash_m=2e-4", "object.grip_force_N=25", "object.coulomb_friction_N=3"}) {
        CAPTURE(hidden);
        const record data = record_of(load_rig("ess", {hidden}), random);
        const count robot = compare(block::robot, data, given);
        const count force = compare(block::force, data, given);
        CHECK(robot.wrongly + force.wrongly == 0);
        CHECK(robot.starts + force.starts > 200);
        CHECK(robot.ruled_out > 0);
    }
}

TEST_CASE("beginning of a record: a grip that gives way too early is ruled out by it, the one that did is not")
{
    SEEDED(random, "beginning of a record*");
    const rig given = load_rig("ess", {});
    CHECK(compare(block::force, record_of(given, random), given).grips_ruled_out >= 40);
    CHECK(compare(block::force, record_of(load_rig("ess", {"object.grip_force_N=25"}), random), given)
              .grips_ruled_out == 0);
}
