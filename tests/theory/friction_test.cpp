#include <cmath>
#include <doctest/doctest.h>
#include <memory>
#include <vector>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/effects/active.h"

using namespace berth;

TEST_CASE("friction: dry friction that differs between the directions builds up from the one level to the other")
{
    constexpr double forwards_N = 5.0;
    constexpr double backwards_N = 2.0;
    constexpr double presliding_m = 1e-4;
    rig rig = load_rig("ess", {});
    set_number(rig, "manipulator.coulomb_friction_N", 0.5 * (forwards_N + backwards_N));
    set_number(rig, "manipulator.coulomb_presliding_m", presliding_m);
    set_number(rig, "manipulator.gravity_offset_N", 0.5 * (forwards_N - backwards_N));
    std::vector<std::unique_ptr<force_stage>> parts;
    for (const char *name :
         {"manipulator.coulomb_friction", "manipulator.gravity_offset", "manipulator.asymmetric_friction"}) {
        parts.push_back(find_effect(name)->on_body(rig));
        parts.back()->start({0.0, 0.0, 0.0, 0.0, 0.0});
    }
    double position_m = 0.0;
    double bent = 0.0; /* Dahl's equation by Euler's method, in steps a thousand times shorter */
    for (int i = 0; i < 4000; i++) {
        const double way_m = i < 1500 || i >= 2200 ? 1e-6 : -1e-6;
        position_m += way_m;
        for (int part = 0; part < 1000; part++) {
            const double direction = way_m > 0.0 ? 1.0 : -1.0;
            bent += 1e-3 * std::abs(way_m) / presliding_m * (direction - bent);
        }
        double sum_N = 0.0;
        for (const auto &one : parts) {
            sum_N += one->force_N({position_m, position_m, 0.0, 0.0, 0.0}, 1e-3);
        }
        CHECK(std::abs(sum_N - bent * (bent > 0.0 ? forwards_N : backwards_N)) < 1e-4 * forwards_N);
    }
}
