#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <vector>

#include "../unit/seeded.h"
#include "sim_hal/effects/drive_limits.h"

namespace
{

constexpr double never = std::numeric_limits<double>::infinity();
constexpr double tick_s = 0.0025;

/* Positions after a step of the setpoints from 0 to `step_m` at the first tick, until it has come to rest there. */
std::vector<double> step_response(double acceleration_m_per_s2, double period_s, double step_m)
{
    berth::drive_limits drive(never, acceleration_m_per_s2, period_s);
    drive.start(0.0);
    std::vector<double> path = {0.0};
    while (path.size() < 100000 && (path.back() != step_m || path[path.size() - 2] != step_m)) {
        path.push_back(drive.take(step_m));
    }
    return path;
}

} // namespace

TEST_CASE("drive limits: a step is made at full acceleration and full braking, and ends where it should")
{
    constexpr double limit = 0.4;
    for (const int whole : {1, 2, 3, 10, 101}) { /* periods of speeding up, so many of braking */
        CAPTURE(whole);
        const double step_m = limit * tick_s * tick_s * whole * (whole + 1);
        const std::vector<double> path = step_response(limit, tick_s, step_m);
        CHECK(*std::max_element(path.begin(), path.end()) <= step_m * (1.0 + 1e-12));
        /* The setpoint is told one tick before the drive can make for it. */
        CHECK(static_cast<int>(path.size()) >= 2 * whole + 1);
        CHECK(static_cast<int>(path.size()) <= 2 * whole + 5);
    }
}

TEST_CASE("drive limits: of short periods the time of a step is that of the bang-bang law, 2 sqrt(d / A)")
{
    constexpr double limit = 0.4;
    constexpr double step_m = 0.013;
    const double shortest_s = 2.0 * std::sqrt(step_m / limit);
    for (const double period_s : {1e-3, 1e-4, 1e-5}) {
        CAPTURE(period_s);
        const double took_s = period_s * static_cast<double>(step_response(limit, period_s, step_m).size());
        CHECK(took_s > shortest_s);
        CHECK(took_s < shortest_s + 10.0 * period_s);
    }
}

TEST_CASE("drive limits: whatever the setpoints do, both limits hold, and what they allow is followed to the bit")
{
    SEEDED(random, "drive limits: whatever*");
    for (int run = 0; run < 50; run++) {
        const double velocity_max = seeded::uniform(random, 0.01, 0.2);
        const double acceleration_max = seeded::uniform(random, 0.05, 2.0);
        berth::drive_limits drive(velocity_max, acceleration_max, tick_s);
        drive.start(0.0);
        double before_m = 0.0;
        double velocity = 0.0;
        double setpoint_m = 0.0;
        for (int n = 0; n < 2000; n++) {
            setpoint_m += n % 100 == 0 ? seeded::uniform(random, -0.01, 0.01)
                                       : seeded::uniform(random, -1.5, 1.5) * velocity_max * tick_s;
            const double position_m = drive.take(setpoint_m);
            const double now = (position_m - before_m) / tick_s;
            CHECK(std::abs(now) <= velocity_max * (1.0 + 1e-9));
            CHECK(std::abs(now - velocity) <= acceleration_max * tick_s * (1.0 + 1e-6));
            velocity = now;
            before_m = position_m;
        }
        for (int n = 0; n < 4000; n++) {
            before_m = drive.take(setpoint_m);
        }
        CHECK(before_m == setpoint_m);
        CHECK(drive.take(setpoint_m + 0.5 * acceleration_max * tick_s * tick_s) ==
              setpoint_m + 0.5 * acceleration_max * tick_s * tick_s);
    }
}
