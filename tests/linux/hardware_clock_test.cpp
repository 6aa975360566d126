/* A controller's own stamps in the kernel's time: against the instants that the frames were really on the bus. */
#include <doctest/doctest.h>
#include <random>

#include "../../hal/linux/hardware_clock.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

constexpr std::int64_t period_ns = 2500000;
constexpr std::int64_t least_delay_ns = 3000;

/* Frames of a minute, the controller's clock off by `start_ns` and `drift_ppm`; the largest error in ns, and none of
 * them later than the kernel saw it. */
std::int64_t largest_error_ns(hardware_clock &clock, std::int64_t start_ns, double drift_ppm)
{
    std::mt19937_64 random(static_cast<std::uint64_t>(test_seed()));
    std::int64_t largest_ns = 0;
    for (std::int64_t i = 1; i < 24000; i++) {
        const std::int64_t true_ns = i * period_ns;
        const auto hardware_ns =
            start_ns + static_cast<std::int64_t>(static_cast<double>(true_ns) * (1.0 + 1e-6 * drift_ppm));
        /* Usually soon, now and then half a millisecond late. */
        const auto late_ns = static_cast<std::int64_t>(random() % 20 == 0 ? random() % 500000 : random() % 4000);
        const std::int64_t software_ns = true_ns + least_delay_ns + late_ns;
        const std::int64_t found_ns = clock.software_time_ns(hardware_ns, software_ns);
        CHECK(found_ns <= software_ns);
        if (i > 100) {
            largest_ns = std::max(largest_ns, std::abs(found_ns - true_ns - least_delay_ns));
        }
    }
    return largest_ns;
}

} // namespace

TEST_CASE("hardware_clock: the interrupt's delay is taken out, whatever the controller's clock shows")
{
    REPRODUCIBLE();
    for (const std::int64_t start_ns :
         {std::int64_t{0}, std::int64_t{-5000000000}, std::int64_t{1700000000000000000}}) {
        for (const double drift_ppm : {0.0, 50.0, -50.0, 100.0}) {
            CAPTURE(start_ns);
            CAPTURE(drift_ppm);
            hardware_clock clock;
            CHECK(largest_error_ns(clock, start_ns, drift_ppm) <
                  10000); /* where stamps of the kernel are up to 500000 */
        }
    }
}

TEST_CASE("hardware_clock: a controller that starts anew, ahead or behind, is found again")
{
    hardware_clock clock;
    CHECK(clock.software_time_ns(1000, 5000) == 5000);
    CHECK(clock.software_time_ns(2001000, 2009000) < 2006000);
    CHECK(clock.software_time_ns(40, 4000000) == 4000000);                   /* from 0 again */
    CHECK(clock.software_time_ns(9000000000, 8000000) == 8000000);           /* far ahead: at once */
    CHECK(clock.software_time_ns(9002500000, 500000000000) == 500000000000); /* behind by more than any delay */
}
} // namespace berth
