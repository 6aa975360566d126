/* Random input that can be had again: a failing check prints the line that reproduces it. */
#ifndef TESTS_UNIT_SEEDED_H
#define TESTS_UNIT_SEEDED_H

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <random>

/* Seeds `name` from BERTH_SEED, or with a fixed seed. `cases` selects the test cases, as doctest takes it. */
#define SEEDED(name, cases)                                                                                         \
    const std::uint64_t name##_seed = seeded::seed();                                                               \
    INFO("reproduce: BERTH_SEED=", name##_seed, " build/cpp_tests -tc='", cases, "'");                              \
    seeded::engine name(name##_seed)

namespace seeded
{

using engine = std::mt19937_64;

inline std::uint64_t seed()
{
    const char *given = std::getenv("BERTH_SEED");
    return given != nullptr ? std::strtoull(given, nullptr, 10) : 20240;
}

inline double uniform(engine &random, double low, double high)
{
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1p-53);
}

inline double log_uniform(engine &random, double low, double high)
{
    return std::exp(uniform(random, std::log(low), std::log(high)));
}

} // namespace seeded

#endif
