/* What is fit to print, with made-up evidence. */
#include <doctest/doctest.h>
#include <string>

#include "../../sim_hal/diagnosis/decide/printable.h"

TEST_CASE("printable: a cause explains, has a size and predicts, or it is not printed and why is said")
{
    const struct {
        const char *name;
        berth::cause_evidence of;
        const char *why;
    } cases[] = {
        {"all is well", {0.5, false, {1.0, 1.0, 1.0}, {2.0, 3.0, 2.0}}, nullptr},
        {"no unseen rows show it", {0.5, false, {}, {}}, nullptr},
        {"printed as 0.0 %", {4e-4, false, {}, {}}, "explains nothing to speak of"},
        {"just more", {6e-4, false, {}, {}}, nullptr},
        {"an interval through zero", {0.5, true, {1.0}, {2.0}}, "may have no size at all"},
        {"as well without it", {0.5, false, {1.0, 1.0}, {1.0, 1.0}}, "does not predict unseen data better"},
        {"worse with it", {0.5, false, {2.0, 2.0}, {1.0, 1.0}}, "does not predict unseen data better"},
        {"one stretch against many",
         {0.5, false, {1, 1, 1, 1, 1, 9}, {1.1, 1.1, 1.1, 1.1, 1.1, 1}},
         "does not predict unseen data better"},
        {"all of the gain in one stretch, and none is worse", {0.5, false, {1, 1, 1}, {1.01, 1.01, 50}}, nullptr},
    };
    for (const auto &one : cases) {
        CAPTURE(std::string(one.name));
        const char *const why = berth::why_not_printable(one.of);
        CHECK((why == nullptr ? std::string() : why) == (one.why == nullptr ? std::string() : one.why));
    }
}

TEST_CASE("printable: the share of draws that gain is that of the binomial law")
{
    /* One stretch of two loses more than the other gains: only two draws of the good one gain, one in four. */
    CHECK(berth::share_of_draws_that_gain({1.0, false, {1.0, 5.0}, {2.0, 1.0}}) ==
          doctest::Approx(0.25).epsilon(0.15));
    CHECK(berth::share_of_draws_that_gain({1.0, false, {}, {}}) == 1.0);
}
