/* What is fit to print, with made-up evidence. */
#include <cmath>
#include <doctest/doctest.h>
#include <string>

#include "../../sim_hal/diagnosis/decide/printable.h"
#include "../../sim_hal/diagnosis/decide/stretches.h"

TEST_CASE("printable: a cause explains, has a size and predicts, or it is not printed and why is said")
{
    const struct {
        const char *name;
        berth::cause_evidence of;
        const char *why;
    } cases[] = {
        {"all is well", {0.5, false, {1.0, 1.0, 1.0}, {2.0, 3.0, 2.0}}, nullptr},
        {"no unseen rows show it", {0.5, false, {}, {}}, "shows in too little of the unseen data"},
        {"one stretch of them", {0.5, false, {1.0}, {50.0}}, "shows in too little of the unseen data"},
        {"two", {0.5, false, {1.0, 1.0}, {50.0, 50.0}}, "shows in too little of the unseen data"},
        {"printed as 0.0 %", {4e-4, false, {1.0, 1.0, 1.0}, {2.0, 3.0, 2.0}}, "explains nothing to speak of"},
        {"just more", {6e-4, false, {1.0, 1.0, 1.0}, {2.0, 3.0, 2.0}}, nullptr},
        {"no share", {std::nan(""), false, {1.0, 1.0, 1.0}, {2.0, 3.0, 2.0}}, "explains nothing to speak of"},
        {"an interval through zero", {0.5, true, {1.0}, {2.0}}, "may have no size at all"},
        {"as well without it",
         {0.5, false, {1.0, 1.0, 1.0}, {1.0, 1.0, 1.0}},
         "does not predict unseen data better"},
        {"worse with it", {0.5, false, {2.0, 2.0, 2.0}, {1.0, 1.0, 1.0}}, "does not predict unseen data better"},
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
    CHECK(berth::share_of_draws_that_gain({1.0, false, {}, {}}) == 0.0);
}

TEST_CASE("printable: stretches share the rows that count, in their order")
{
    CHECK(berth::sums_by_stretch({1, 2, 4, 8, 16, 32}, {true, true, false, true, true, false}, 2) ==
          std::vector<double>{3, 24});
    CHECK(berth::sums_by_stretch({1, 2}, {false, false}, 2) == std::vector<double>{0, 0});
}

TEST_CASE("printable: a stretch counts where the cause does more than the noise, or a good part of its own mean")
{
    const struct {
        const char *name;
        std::vector<double> change;
        double noise;
        std::vector<double> kept;
    } cases[] = {
        {"all far above the noise", {9, 8, 7}, 1.0, {9, 8, 7}},
        {"small but everywhere", {0.2, 0.1, 0.3}, 1.0, {0.2, 0.1, 0.3}},
        {"in one of three", {9, 0.1, 0.1}, 1.0, {9}},
        {"above the noise beside a much larger one", {900, 2, 0.5}, 1.0, {900, 2}},
        {"nowhere", {0, 0, 0}, 1.0, {}},
    };
    for (const auto &one : cases) {
        CAPTURE(std::string(one.name));
        berth::cause_evidence made;
        berth::add_what_shows(made, {one.change, one.change, one.change}, one.noise);
        CHECK(made.unseen_with == one.kept);
    }
}

TEST_CASE("printable: the gain is that of all stretches, within the interval of their draws")
{
    const berth::unseen_gain all_alike = berth::gain_of({1.0, false, {1.0, 1.0, 1.0}, {4.0, 4.0, 4.0}});
    CHECK(all_alike.value == 0.75);
    CHECK(all_alike.low == 0.75);
    CHECK(all_alike.high == 0.75);
    const berth::unseen_gain differ = berth::gain_of({1.0, false, {1.0, 1.0, 1.0}, {2.0, 2.0, 4.0}});
    CHECK(differ.value == doctest::Approx(1.0 - 3.0 / 8.0));
    CHECK(differ.low == 0.5);
    CHECK(differ.high == 0.75);
    CHECK(berth::gain_of({}).value == 0.0);
}

TEST_CASE("printable: the probability is the smaller one of draws and BIC, and never one")
{
    const berth::cause_evidence gains{1.0, false, {1.0, 1.0, 1.0}, {4.0, 4.0, 4.0}};
    const berth::cause_evidence loses{1.0, false, {4.0, 4.0, 4.0}, {1.0, 1.0, 1.0}};
    CHECK(berth::probability_of(gains, 1e6) == doctest::Approx(0.999).epsilon(1e-4));
    CHECK(berth::probability_of(gains, 0.0) == 0.5);
    CHECK(berth::probability_of(gains, -20.0) < 1e-4);
    CHECK(berth::probability_of(loses, 1e6) == 0.0);
    CHECK(berth::probability_of({}, 1e6) == 0.0);
}

TEST_CASE("printable: a rival has a size and predicts better, however little sure")
{
    const auto why = [](const berth::cause_evidence &rival) {
        const char *const said = berth::why_no_rival(rival);
        return std::string(said == nullptr ? "" : said);
    };
    CHECK(why({0.5, false, {1.0, 2.0}, {2.0, 1.5}}).empty());
    CHECK(why({0.5, true, {1.0, 1.0}, {2.0, 2.0}}) == "may have no size at all");
    CHECK(why({0.5, false, {2.0, 1.0}, {1.0, 1.5}}) == "does not predict unseen data better");
    CHECK(why({0.5, false, {}, {}}) == "does not predict unseen data better");
}
