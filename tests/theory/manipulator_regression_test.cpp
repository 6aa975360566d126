/* The equation of motion by closed forms: a motion of three sines, and the push that it takes. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../firmware/pi.h"
#include "hal/rig/keys.h"
#include "sim_hal/diagnosis/fit/base.h"
#include "sim_hal/diagnosis/fit/manipulator_regression.h"

namespace
{

constexpr double period_s = 0.0025;
constexpr std::size_t rows = 8000;

struct motion {
    double x_m = 0.0;
    double v_m_per_s = 0.0;
    double a_m_per_s2 = 0.0;
};

motion motion_at(double time_s)
{
    motion made;
    for (const auto &[amplitude_m, frequency_Hz] :
         {std::pair{6e-3, 0.31}, std::pair{3e-3, 0.83}, std::pair{1e-3, 1.7}}) {
        const double w = berth::two_pi * frequency_Hz;
        made.x_m += amplitude_m * std::sin(w * time_s);
        made.v_m_per_s += amplitude_m * w * std::cos(w * time_s);
        made.a_m_per_s2 -= amplitude_m * w * w * std::sin(w * time_s);
    }
    return made;
}

constexpr double mass_kg = 206.0;
constexpr double damping_N_s_per_m = 128.0;
constexpr double stiffness_N_per_m = 7700.0;
constexpr double coulomb_N = 4.0;
constexpr double offset_N = -1.5;
constexpr double asymmetry_N_s_per_m = 40.0;
constexpr double cubic_N_per_m3 = 2e6;

/* With all of it, without the cubic spring, or without what turns with the direction. */
enum class terms { all, no_cubic, smooth };

double push_at(double time_s, terms of)
{
    const motion now = motion_at(time_s);
    const double direction = of == terms::smooth ? 0.0 : now.v_m_per_s < 0.0 ? -1.0 : 1.0;
    const double cubic = of == terms::no_cubic ? 0.0 : cubic_N_per_m3;
    return mass_kg * now.a_m_per_s2 + damping_N_s_per_m * now.v_m_per_s + stiffness_N_per_m * now.x_m +
           direction * (coulomb_N + asymmetry_N_s_per_m * now.v_m_per_s) + offset_N + cubic * std::pow(now.x_m, 3);
}

berth::record record_of(terms of)
{
    berth::record made;
    made.period_s = period_s;
    made.segments = {{0, rows}};
    for (std::size_t n = 0; n < rows; n++) {
        const double time_s = period_s * static_cast<double>(n);
        made.time_s.push_back(time_s);
        made.command_position_m.push_back(motion_at(time_s).x_m);
        made.operator_force_N.push_back(push_at(time_s + 0.5 * period_s, of)); /* held over the tick */
    }
    return made;
}

berth::rig given()
{
    berth::rig rig;
    rig.firmware.manipulator.mass_kg = 200.0;
    rig.firmware.manipulator.damping_N_s_per_m = 125.0;
    rig.firmware.manipulator.stiffness_N_per_m = 7900.0;
    return rig;
}

berth::fit_result base_of(const berth::rig &rig)
{
    berth::fit_result made;
    made.rig = rig;
    made.parameters = berth::base_parameters(berth::block::manipulator, rig);
    return made;
}

const berth::effect &effect_named(const char *name)
{
    return *berth::find_effect(name);
}

} // namespace

TEST_CASE("manipulator regression: every size of a closed motion is found from 5 % off, the priors notwithstanding")
{
    const berth::record record = record_of(terms::all);
    const berth::sample_events none;
    const berth::rig rig = given();
    const berth::block_model model(berth::block::manipulator, record, rig, none, berth::held_out_parts::none);
    const std::vector<const berth::effect *> found = {&effect_named("manipulator.coulomb_friction"),
                                                      &effect_named("manipulator.gravity_offset"),
                                                      &effect_named("manipulator.asymmetric_friction")};
    const auto starts =
        berth::regressed_starts(model, base_of(rig), found, effect_named("manipulator.cubic_stiffness"));
    REQUIRE(!starts.empty());
    const berth::rig &made = starts.front();
    const auto is_near = [&](const char *key, double value) {
        CAPTURE(key);
        CHECK(berth::value_of(made, key) == doctest::Approx(value).epsilon(3e-3));
    };
    is_near("manipulator.mass_kg", mass_kg);
    is_near("manipulator.damping_N_s_per_m", damping_N_s_per_m);
    is_near("manipulator.stiffness_N_per_m", stiffness_N_per_m);
    is_near("manipulator.coulomb_friction_N", coulomb_N);
    is_near("manipulator.gravity_offset_N", offset_N);
    is_near("manipulator.damping_asymmetry_N_s_per_m", asymmetry_N_s_per_m);
    is_near("manipulator.cubic_stiffness_N_per_m3", cubic_N_per_m3);
}

TEST_CASE("manipulator regression: what it does not know, or cannot decide, has no starts")
{
    const berth::record record = record_of(terms::no_cubic);
    const berth::sample_events none;
    berth::rig rig = given();
    const auto starts_of = [&](const berth::rig &of, const std::vector<const berth::effect *> &found,
                               const char *name, berth::block block = berth::block::manipulator) {
        const berth::block_model model(block, record, of, none, berth::held_out_parts::none);
        return berth::regressed_starts(model, base_of(of), found, effect_named(name)).size();
    };
    CHECK(starts_of(rig, {}, "manipulator.gravity_offset") > 0);
    CHECK(starts_of(rig, {}, "manipulator.backlash") == 0);
    CHECK(starts_of(rig, {&effect_named("manipulator.backlash")}, "manipulator.gravity_offset") == 0);
    rig.firmware.manipulator.stiffness_N_per_m = 0.0; /* its replay's windows are too short */
    CHECK(starts_of(rig, {}, "manipulator.gravity_offset") == 0);
}

TEST_CASE("manipulator regression: rows that no fit may see decide nothing")
{
    berth::record record = record_of(terms::no_cubic);
    for (std::size_t n = 4000; n < rows; n++) {
        record.operator_force_N[n] = 1e4;
    }
    const berth::sample_events none;
    const berth::rig rig = given();
    berth::block_model model(berth::block::manipulator, record, rig, none, berth::held_out_parts::none);
    std::vector<berth::row_use> uses = model.uses();
    std::fill(uses.begin() + 4000, uses.end(), berth::row_use::held_out);
    model.use(uses);
    const auto starts = berth::regressed_starts(
        model, base_of(rig),
        {&effect_named("manipulator.coulomb_friction"), &effect_named("manipulator.gravity_offset")},
        effect_named("manipulator.asymmetric_friction"));
    REQUIRE(!starts.empty());
    CHECK(berth::value_of(starts.front(), "manipulator.gravity_offset_N") ==
          doctest::Approx(offset_N).epsilon(3e-3));
}

TEST_CASE("block model: beside a rig the error goes as its own differences say, with the windows' starts kept")
{
    const berth::record record = record_of(terms::smooth);
    const berth::sample_events none;
    /* Where little is left: what it leaves out grows with that. */
    berth::rig rig = given();
    for (const auto &[key, value] : {std::pair{"manipulator.mass_kg", mass_kg},
                                     {"manipulator.damping_N_s_per_m", damping_N_s_per_m},
                                     {"manipulator.stiffness_N_per_m", stiffness_N_per_m},
                                     {"manipulator.gravity_offset_N", offset_N},
                                     {"manipulator.cubic_stiffness_N_per_m3", cubic_N_per_m3}}) {
        berth::set_number(rig, key, value);
    }
    berth::block_model model(berth::block::manipulator, record, rig, none, berth::held_out_parts::none);
    std::vector<double> here;
    std::vector<double> again;
    model.error(rig, here);
    model.error_beside(rig, again);
    for (std::size_t n = 0; n < here.size(); n++) {
        REQUIRE(again[n] == doctest::Approx(here[n]).epsilon(1e-12));
    }
    berth::rig moved = rig;
    berth::set_number(moved, "manipulator.mass_kg", 1.001 * berth::value_of(rig, "manipulator.mass_kg"));
    std::vector<double> beside;
    std::vector<double> there;
    model.error_beside(moved, beside);
    model.error(moved, there);
    double difference = 0.0;
    double change = 0.0;
    for (std::size_t n = 0; n < here.size(); n++) {
        difference += std::pow(there[n] - beside[n], 2);
        change += std::pow(there[n] - here[n], 2);
    }
    CHECK(std::sqrt(difference / change) < 0.02);
}
