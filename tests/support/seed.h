/* Randomised tests: a fixed seed unless the environment names another, and how to repeat a failure. */
#ifndef TESTS_SUPPORT_SEED_H
#define TESTS_SUPPORT_SEED_H

#include <cstdint>
#include <cstdlib>
#include <doctest/doctest.h>
#include <string>

#include "sanitized.h"

namespace berth
{

/* How many cases a test draws: of `count`, a tenth under sanitizers, which take ten times as long. */
constexpr int cases_to_draw(int count)
{
#ifdef BERTH_SANITIZED
    return count / 10;
#else
    return count;
#endif
}

inline std::int64_t test_seed()
{
    const char *given = std::getenv("BERTH_TEST_SEED");
    return given != nullptr ? std::atoll(given) : 20260;
}

inline std::string reproduction()
{
    return "BERTH_TEST_SEED=" + std::to_string(test_seed()) + " build/cpp_tests -tc='" +
           doctest::getContextOptions()->currentTest->m_name + "'";
}

} // namespace berth

/* Shown with every failure of the test case that it stands in. */
#define REPRODUCIBLE() INFO("reproduce with: ", berth::reproduction())

#endif
