/* What a loop that is bound to a CPU leaves to the threads beside it. */
#include "../../hal/linux/real_time.h"

#include <doctest/doctest.h>

namespace berth
{

namespace
{

cpu_set_t own_cpus()
{
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    sched_getaffinity(0, sizeof cpus, &cpus);
    return cpus;
}

} // namespace

TEST_CASE("real time: other threads stay off the loop's CPU if there is another, and all is as before in the end")
{
    const cpu_set_t before = own_cpus();
    std::size_t first = 0;
    while (!CPU_ISSET(first, &before)) {
        first++;
    }
    {
        target_rig target;
        target.cpu = static_cast<std::int64_t>(first);
        const real_time tried(target);
        const cpu_set_t loop = own_cpus();
        CHECK(CPU_COUNT(&loop) == 1);
        CHECK(CPU_ISSET(first, &loop));
        CHECK(CPU_COUNT(&tried.other_cpus()) == (CPU_COUNT(&before) > 1 ? CPU_COUNT(&before) - 1 : 1));
        CHECK((CPU_ISSET(first, &tried.other_cpus()) != 0) == (CPU_COUNT(&before) == 1));
    }
    const cpu_set_t after = own_cpus();
    CHECK(CPU_EQUAL(&before, &after));
}

} // namespace berth
