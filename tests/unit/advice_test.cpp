#include <doctest/doctest.h>
#include <string>
#include <vector>

#include "../../sim_hal/advice.h"

namespace berth
{

namespace
{

/* A loop that is unstable at `value` and stable from `above` on. */
parameter_limits cured_above(std::string_view key, double value, double above)
{
    return {key, value, 0.1 * value, 10.0 * value, {{above, true, "", {}, ""}}, {{above, 10.0 * value}}, {}};
}

} // namespace

TEST_CASE("advice: no longer delay is advised, even where it is the nearest change that would help")
{
    for (const char *delay : {"robot.dead_time_ms", "robot.lag_ms", "sensor.delay_ms", "sensor.lag_ms"}) {
        CAPTURE(std::string(delay));
        const std::vector<parameter_limits> both{cured_above(delay, 40.0, 41.0),
                                                 cured_above("manipulator.mass_kg", 100.0, 150.0)};
        const auto cure = nearest_limit(both, false);
        REQUIRE(cure);
        CHECK(cure->key == "manipulator.mass_kg");
        CHECK_FALSE(nearest_limit({both.front()}, false));

        const auto end = nearest_limit(both, true); /* of a stable loop: what ends stability, wherever it is */
        REQUIRE(end);
        CHECK(end->key == delay);
    }
}

} // namespace berth
