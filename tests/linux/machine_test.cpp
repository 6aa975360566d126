/* What the kernel's files say of the machine. */
#include <doctest/doctest.h>
#include <sstream>

#include "../../hal/linux/machine.h"

namespace berth
{

TEST_CASE("machine: a list of CPUs has those of its ranges, ends included")
{
    for (const std::int64_t cpu : {0, 1, 2, 5, 12}) {
        CAPTURE(cpu);
        CHECK(has_cpu("0-2,5,12", cpu));
    }
    for (const std::int64_t cpu : {-1, 3, 4, 6, 11, 13}) {
        CAPTURE(cpu);
        CHECK(!has_cpu("0-2,5,12", cpu));
    }
    CHECK(!has_cpu("", 0));
}

TEST_CASE("machine: an interrupt is found by the name of its device, shared or not, and by no other")
{
    const char *const table = "           CPU0       CPU1\n"
                              "  0:         34          0   IO-APIC   2-edge      timer\n"
                              " 21:         10          0   IO-APIC  21-fasteoi   can10, eth0\n";
    const auto number_of = [&](const char *device) {
        std::istringstream interrupts(table);
        return interrupt_of(device, interrupts);
    };
    CHECK(number_of("can10") == "21");
    CHECK(number_of("eth0") == "21");
    CHECK(number_of("timer") == "0");
    CHECK(number_of("can1") == "");
}

} // namespace berth
