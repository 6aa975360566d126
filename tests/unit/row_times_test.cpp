/* Rows with uneven stamps, taken at them or not, against a motion that is known at every time. */
#include <cmath>
#include <doctest/doctest.h>
#include <random>
#include <string>
#include <vector>

#include "../../sim_hal/diagnosis/record/row_times.h"

namespace
{

constexpr double row_period_s = 0.005;
constexpr std::size_t row_count = 2000;

double motion_m(double time_s)
{
    return 4e-3 * std::sin(2.0 * time_s) + 1e-3 * std::sin(17.0 * time_s + 1.0);
}

struct uneven_rows {
    std::vector<double> stamp_s;
    std::vector<double> due_s;
    std::vector<double> position_m;
};

/* Stamps off by up to this share of a period; a position is that of its stamp, or of when it was due. */
uneven_rows made_rows(double jitter, bool at_stamps, double noise_m)
{
    std::minstd_rand random(11);
    std::uniform_real_distribution<double> off(-jitter * row_period_s, jitter * row_period_s);
    std::normal_distribution<double> noise;
    uneven_rows made;
    for (std::size_t n = 0; n < row_count; n++) {
        made.due_s.push_back(3.0 + row_period_s * static_cast<double>(n));
        made.stamp_s.push_back(made.due_s.back() + off(random));
        made.position_m.push_back(motion_m(at_stamps ? made.stamp_s.back() : made.due_s.back()) +
                                  noise_m * noise(random));
    }
    return made;
}

} // namespace

TEST_CASE("row times: a smooth motion tells whether rows were taken at their stamps")
{
    const struct {
        const char *name;
        double jitter;
        bool at_stamps;
        double noise_m;
        bool is_told;
    } cases[] = {{"taken at uneven times", 0.3, true, 0.0, true},
                 {"the same with noise well below what the times do", 0.3, true, 1e-6, true},
                 {"a little uneven", 0.02, true, 0.0, true},
                 {"taken evenly, and stamped unevenly", 0.3, false, 0.0, false},
                 {"noise hides it", 0.3, true, 1e-3, false},
                 {"even stamps", 0.0, true, 1e-6, false}};
    for (const auto &one : cases) {
        CAPTURE(std::string(one.name));
        const uneven_rows made = made_rows(one.jitter, one.at_stamps, one.noise_m);
        CHECK(berth::are_taken_at_stamps(made.stamp_s, made.due_s, made.position_m) == one.is_told);
    }
}

TEST_CASE("row times: values at even times are those of the motion")
{
    const uneven_rows made = made_rows(0.3, true, 0.0);
    const std::vector<double> even = berth::at_due_times(made.stamp_s, made.due_s, made.position_m);
    REQUIRE(even.size() == row_count);
    for (std::size_t n = 0; n < row_count; n++) {
        CHECK(even[n] == doctest::Approx(motion_m(made.due_s[n])).epsilon(0.0).scale(1.0).epsilon(1e-7));
    }
    CHECK(berth::at_due_times({0.0, 0.1}, {0.0, 0.1}, {1.0, 2.0}) == std::vector<double>{1.0, 2.0});
}
