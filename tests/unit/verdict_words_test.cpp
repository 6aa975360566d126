/* What stands beside a verdict: its words, advice and schedule, its margin, the intervals of its limits. */
#include <doctest/doctest.h>

#include "../../sim_hal/schedule.h"
#include "../../sim_hal/stability/stable_intervals.h"
#include "../../sim_hal/verdict_words.h"

namespace berth
{

TEST_CASE("verdict: safe means stable, with at least the margin wanted")
{
    stability_verdict stable;
    stable.is_stable = true;
    stability_margin margin;
    margin.dead_time_ms = 5.0;
    CHECK(is_safe(stable, margin, 0.0));
    CHECK(is_safe(stable, margin, 5.0));
    CHECK_FALSE(is_safe(stable, margin, 5.1));
    CHECK_FALSE(is_safe(stable, {}, 1.0));
    margin.is_dead_time_open = true; /* as far as was searched, and no further */
    CHECK_FALSE(is_safe(stable, margin, 5.1));
    CHECK_FALSE(is_safe(stability_verdict(), margin, 0.0));
}

TEST_CASE("limits: an interval of one value is none, unless it is the rig's own")
{
    const std::vector<stable_interval> all{{4.0, 4.0}, {8.0, 8.00004}, {12.0, 12.01}};
    CHECK(without_single_values(all, 10.0).size() == 1);
    CHECK(without_single_values(all, 10.0).front().from == 12.0);
    CHECK(without_single_values(all, 4.0).front().to == 4.0);
    CHECK(without_single_values(all, 4.0).size() == 2);
    const std::vector<double> grid{1.0, 2.0, 3.0, 4.0};
    CHECK(intervals_between(grid, true, {2.5}).front().to == 2.5);
    CHECK(intervals_between(grid, false, {2.5}).front().to == 4.0);
}

TEST_CASE("margin: where the loop is stable again")
{
    stability_margin margin;
    margin.dead_time_ms = 5.0;
    margin.stable_again_ms = {{20.0, 24.5}};
    CHECK(margin_words(margin) ==
          "the dead time may grow by 5 ms before the loop is unstable; stable again from 20 to "
          "24.5 ms of dead time");
    margin.is_again_open = true;
    CHECK(margin_words(margin) ==
          "the dead time may grow by 5 ms before the loop is unstable; stable again from 20 to at least "
          "24.5 ms of dead time");
    margin.stable_again_ms.push_back({30.0, 31.0});
    margin.modulus = 0.25;
    CHECK(margin_words(margin) ==
          "the dead time may grow by 5 ms before the loop is unstable; stable again from 20 to "
          "24.5 ms of dead time, and in 1 more beyond; modulus 0.2500 (0: unstable)");
}

TEST_CASE("verdict: a rate has the digits that its interval leaves it")
{
    CHECK(rate_text(0.298364, 4e-5) == "0.29836 +- 0.00004");
    CHECK(rate_text(1.10502, 0.2) == "1.1 +- 0.2");
    CHECK(rate_text(25.3, 12.0) == "25 +- 12");
    CHECK(rate_text(4.32123, 0.0) == "4.32");
    CHECK(rate_text(0.0118, 0.0098) == "0.0118 +- 0.0098");
}

TEST_CASE("advice is rounded to where the loop is stable")
{
    CHECK(rounded_beyond(194.576, 210.0, 4) == doctest::Approx(194.5));
    CHECK(rounded_beyond(194.576, 150.0, 4) == doctest::Approx(194.6));
    CHECK(rounded_beyond(-0.0123456, -0.02, 3) == doctest::Approx(-0.0123));
    CHECK(rounded_beyond(-0.0123456, -0.01, 3) == doctest::Approx(-0.0124));
    stability_advice advice;
    advice.change = parameter_cure{"object.mass_kg", 210.0, 194.5, -0.001};
    advice.compensation = cure{"--with prediction", -0.4712};
    CHECK(advice_text(advice) == "object.mass_kg below 194.5, or --with prediction: -0.47 /s");
    advice.change->value = 210.1;
    CHECK(advice_text(advice) == "object.mass_kg above 210.1, or --with prediction: -0.47 /s");
    advice.compensation->growth_per_s = -0.0066;
    CHECK(advice_text(advice) ==
          "object.mass_kg above 210.1, or --with prediction: -0.0066 /s, barely stable: halves every 105 s");
    CHECK(advice_text({}).empty());
    advice = {};
    advice.was_sought = true;
    CHECK(advice_text(advice) == "no single parameter and no compensation that was tried makes it stable");
}

TEST_CASE("verdict: a schedule is reported stretch by stretch, with the growth of the stretches that do not decide")
{
    growth_prediction told{0.5, {}, 0.0, prediction_source::eigenvalues};
    const auto loop = [](double from_s, double growth_per_s) {
        return scheduled_growth{from_s, 20.0, 1e3, growth_per_s, 0.0, growth_per_s < 0.0};
    };
    CHECK(schedule_words(told).empty());
    told.schedule = {loop(0.1, -0.2), loop(5.0, 0.5)};
    CHECK(schedule_words(told) == "stable before 5 s (-0.2 /s), unstable from then on");
    CHECK(judge(told, {}).because ==
          "stable before 5 s (-0.2 /s), unstable from then on: the eigenvalues say +0.5 /s: doubles every 1.39 s");
    told.schedule = {loop(0.1, -0.2), loop(2.0, 0.5), loop(5.0, 0.4), loop(7.0, -0.1)};
    CHECK(schedule_words(told) ==
          "stable before 2 s (-0.2 /s), unstable from 2 to 7 s, stable from then on (-0.1 /s)");
}

} // namespace berth
