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
    using numbers = std::vector<std::string>;
    const char *const table = "           CPU0       CPU1\n"
                              "  0:         34          0   IO-APIC   2-edge      timer\n"
                              " 21:         10          0   IO-APIC  21-fasteoi   can10, eth0\n"
                              " 54:          7          0  pinctrl-bcm2835  25 Level     spi0.0\n"
                              " 60:          7          0     GICv3  60 Level     can2\n"
                              " 61:          7          0     GICv3  61 Level     can2\n";
    const auto numbers_of = [&](const std::vector<std::string> &names) {
        std::istringstream interrupts(table);
        return interrupts_of(names, interrupts);
    };
    CHECK(numbers_of({"can10"}) == numbers{"21"});
    CHECK(numbers_of({"eth0"}) == numbers{"21"});
    CHECK(numbers_of({"timer"}) == numbers{"0"});
    CHECK(numbers_of({"can1"}).empty());
    CHECK(numbers_of({"can0", "spi0.0"}) == numbers{"54"});
    CHECK(numbers_of({"can2"}) == numbers{"60", "61"});
}

} // namespace berth
