#include <doctest/doctest.h>

#include <vector>

#include "hal/linux/output_level.h"

namespace
{

/* A line whose next writes may fail, and what was written to it. */
struct fake_line {
    berth::output_level output;
    int failures = 0;
    std::vector<int> written;

    void set(std::uint8_t level)
    {
        output.set(level, [&](int value) {
            written.push_back(value);
            return failures-- > 0 ? -1 : 0;
        });
    }
};

} // namespace

TEST_CASE("output_level: a level is written once")
{
    fake_line line;
    for (const std::uint8_t level : {0, 0, 1, 1, 1, 0, 0}) {
        line.set(level);
    }
    CHECK(line.written == std::vector{1, 0});
}

TEST_CASE("output_level: a write that failed is repeated until it succeeds")
{
    fake_line line;
    line.failures = 2;
    for (int i = 0; i < 5; i++) {
        line.set(1);
    }
    CHECK(line.written == std::vector{1, 1, 1});
}

TEST_CASE("output_level: after a failed write the old level is written, too")
{
    fake_line line;
    line.failures = 1;
    line.set(1); /* nobody knows whether the line has changed */
    line.set(0);
    CHECK(line.written == std::vector{1, 0});
}
