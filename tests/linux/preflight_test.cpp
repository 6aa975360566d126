/* What the preflight makes of what the kernel says, where no machine at hand says all of it. */
#include "../../hal/linux/preflight.h"

#include <doctest/doctest.h>

namespace berth
{

TEST_CASE("preflight: throttling is off without a share, or with all of the period")
{
    CHECK(judge_throttling("-1", "1000000").verdict == verdict::fine);
    CHECK(judge_throttling("1000000", "1000000").verdict == verdict::fine);
    CHECK(judge_throttling("", "").verdict == verdict::fine); /* a kernel without */
    const finding throttled = judge_throttling("95000", "100000");
    CHECK(throttled.verdict == verdict::warning);
    CHECK(throttled.text == "real-time threads may run 95000 of every 100000 us");
    CHECK(throttled.remedy == "sysctl kernel.sched_rt_runtime_us=-1");
}

TEST_CASE("preflight: isolation is the loop's own CPU kept free, not just any")
{
    CHECK(judge_isolation("2-3", 3).verdict == verdict::fine);
    CHECK(judge_isolation("2-3", 3).text == "isolated: 2-3; the loop is bound to 3");
    CHECK(judge_isolation("2-3", 1).verdict == verdict::warning);
    CHECK(judge_isolation("2-3", -1).verdict == verdict::warning);
    CHECK(judge_isolation("", 0).verdict == verdict::warning);
    CHECK(!judge_isolation("", 0).remedy.empty());
}

TEST_CASE("preflight: a bus interrupts another CPU than the loop's, or it is not known to")
{
    CHECK(judge_interrupt("can0", "0-2", 3).verdict == verdict::fine);
    CHECK(judge_interrupt("can0", "0-2", -1).verdict == verdict::fine);
    CHECK(judge_interrupt("can0", "0,2-3", 3).verdict == verdict::warning);
    const finding unknown = judge_interrupt("can0", "", 3);
    CHECK(unknown.verdict == verdict::warning);
    CHECK(unknown.text == "none of its own");
}

TEST_CASE("preflight: a controller that sees errors is told of")
{
    CHECK(judge_bus_errors("can0", "error-active").verdict == verdict::fine);
    CHECK(judge_bus_errors("can0", "error-warning").verdict == verdict::warning);
    CHECK(judge_bus_errors("can0", "error-passive").text == "error-passive");
}

} // namespace berth
