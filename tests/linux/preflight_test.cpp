/* What the preflight makes of what the kernel says, where no machine at hand says all of it. */
#include "../../hal/linux/preflight.h"

#include <algorithm>
#include <doctest/doctest.h>
#include <filesystem>
#include <fstream>

#include "../support/files.h"

namespace berth
{

namespace
{

/* /proc and /sys of a machine, as far as they were written down. */
class recorded_tree
{
  public:
    recorded_tree(std::initializer_list<std::pair<const char *, const char *>> files)
    {
        for (const auto &[path, line] : files) {
            const std::filesystem::path file = root() + path;
            std::filesystem::create_directories(file.parent_path());
            std::ofstream(file) << line << "\n";
        }
    }

    std::string root() const { return folder_ / "root"; }

  private:
    temporary_folder folder_;
};

constexpr const char *rt_runtime = "/proc/sys/kernel/sched_rt_runtime_us";
constexpr const char *rt_period = "/proc/sys/kernel/sched_rt_period_us";

const finding *finding_of(const std::vector<finding> &all, const std::string &subject)
{
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const finding &one) { return one.subject == subject; });
    return found == all.end() ? nullptr : &*found;
}

} // namespace

TEST_CASE("preflight: before Linux 6.12 throttling is off without a share, or with all of the period")
{
    const struct {
        recorded_tree tree;
        bool is_fine;
    } cases[] = {{{{rt_runtime, "-1"}, {rt_period, "1000000"}}, true},
                 {{{rt_runtime, "1000000"}, {rt_period, "1000000"}}, true},
                 {{}, true}, /* a kernel without */
                 {{{rt_runtime, "95000"}, {rt_period, "100000"}}, false}};
    for (const auto &one : cases) {
        const auto found = judge_throttling(one.tree.root(), "6.1.0-28-rt-amd64", 1);
        REQUIRE(found.size() == 1);
        CHECK((found[0].verdict == verdict::fine) == one.is_fine);
    }
    const auto throttled = judge_throttling(cases[3].tree.root(), "5.10.0", 1);
    CHECK(throttled[0].text == "real-time threads may run 95000 of every 100000 us");
    CHECK(throttled[0].remedy == "sysctl kernel.sched_rt_runtime_us=-1");
}

TEST_CASE("preflight: from Linux 6.12 on the fair server of the loop's CPU is looked at")
{
    const recorded_tree tree{{rt_runtime, "950000"},
                             {rt_period, "1000000"},
                             {"/sys/kernel/debug/sched/fair_server/cpu0/runtime", "50000000"},
                             {"/sys/kernel/debug/sched/fair_server/cpu0/period", "1000000000"},
                             {"/sys/kernel/debug/sched/fair_server/cpu3/runtime", "0"},
                             {"/sys/kernel/debug/sched/fair_server/cpu3/period", "1000000000"}};
    for (const char *release : {"6.12.0", "6.12.43+deb13-rt-amd64", "6.17.2", "7.0.1"}) {
        const auto on = judge_throttling(tree.root(), release, 0);
        REQUIRE(finding_of(on, "fair server") != nullptr);
        CHECK(finding_of(on, "fair server")->verdict == verdict::warning);
        CHECK(finding_of(on, "fair server")->text.find("cpu0: 50 of every 1000 ms") != std::string::npos);
        CHECK(finding_of(on, "fair server")->remedy == "echo 0 > /sys/kernel/debug/sched/fair_server/cpu0/runtime");
        CHECK(finding_of(on, "throttling")->verdict == verdict::fine);
        CHECK(finding_of(on, "throttling")->text.find("950000 of every 1000000 us; since Linux 6.12") == 0);
    }
    const auto off = judge_throttling(tree.root(), "6.12.0", 3);
    CHECK(finding_of(off, "fair server")->verdict == verdict::fine);
    const auto any = judge_throttling(tree.root(), "6.12.0", -1);
    CHECK(finding_of(any, "fair server")->remedy == "echo 0 > /sys/kernel/debug/sched/fair_server/cpu0/runtime");
    const recorded_tree unmounted{{rt_runtime, "-1"}, {rt_period, "1000000"}};
    const auto unknown = judge_throttling(unmounted.root(), "6.12.0", 0);
    CHECK(finding_of(unknown, "fair server")->verdict == verdict::warning);
    CHECK(finding_of(unknown, "fair server")->text.find("could not be looked at") == 0);
    CHECK(finding_of(unknown, "fair server")->remedy.find("mount -t debugfs") == 0);
    CHECK(finding_of(unknown, "throttling")->text.find("off; since Linux 6.12") == 0);
    CHECK(finding_of(judge_throttling(tree.root(), "6.11.9", 0), "fair server") == nullptr);
}

TEST_CASE("preflight: a remedy takes an interface that is up down before it sets it")
{
    can_link link;
    link.is_can = true;
    const std::string set = "ip link set can0 type can restart-ms 100";
    CHECK(bus_remedy("can0", link, 500000) ==
          "ip link set can0 type can bitrate 500000 restart-ms 100 && ip link set can0 up");
    CHECK(judge_restart("can0", link).remedy.find(set + " (") == 0);
    link.is_up = true;
    link.state = "error-active";
    CHECK(judge_restart("can0", link).verdict == verdict::warning);
    CHECK(judge_restart("can0", link).remedy.find("ip link set can0 down && " + set + " && ip link set can0 up (") ==
          0);
    CHECK(judge_restart("can0", link).remedy.find("Operation not supported") != std::string::npos);
    link.state = "bus-off";
    CHECK(bus_remedy("can0", link, 1000000) == "ip link set can0 down && ip link set can0 type can bitrate 1000000 "
                                               "restart-ms 100 && ip link set can0 up");
    CHECK(judge_restart("can0", link).remedy.find("ip link set can0 type can restart ") == 0);
    CHECK(judge_restart("can0", link).remedy.find("ip link set can0 down && " + set) != std::string::npos);
    link.restart_ms = 100;
    CHECK(judge_restart("can0", link).verdict == verdict::fine);
    CHECK(judge_restart("can0", link).remedy.empty());
}

TEST_CASE("preflight: a line whose name others have as well is none")
{
    const std::vector<seen_line> seen = {{"gpiochip0", "soc", "STOP", false},  {"gpiochip0", "soc", "TICK", false},
                                         {"gpiochip2", "pca", "STOP", false},  {"gpiochip2", "pca", "TWICE", false},
                                         {"gpiochip2", "pca", "TWICE", false}, {"gpiochip3", "pca", "STOP", true}};
    const struct {
        const char *name;
        const char *chip;
        verdict wanted;
        const char *text;
    } cases[] = {
        {"STOP", "", verdict::missing, "STOP is on gpiochip0, gpiochip2 and gpiochip3"},
        {"STOP", "gpiochip0", verdict::fine, "STOP on gpiochip0"},
        {"STOP", "soc", verdict::fine, "STOP on gpiochip0"},
        {"STOP", "pca", verdict::missing, "STOP is on gpiochip2 and gpiochip3"},
        {"STOP", "gpiochip3", verdict::missing, "STOP on gpiochip3 is held by another program"},
        {"TICK", "", verdict::fine, "TICK on gpiochip0"},
        {"TWICE", "", verdict::missing, "TWICE names 2 lines of gpiochip2"},
        {"NOWHERE", "", verdict::missing, "no line is called NOWHERE"},
    };
    for (const auto &one : cases) {
        CAPTURE(one.text);
        const finding found =
            judge_line("target.emergency_stop_line", one.name, lines_called(seen, one.name, one.chip));
        CHECK(found.verdict == one.wanted);
        CHECK(found.text == one.text);
        CHECK(found.remedy.empty() == (one.wanted == verdict::fine));
    }
    CHECK(judge_line("k", "STOP", lines_called(seen, "STOP", "")).remedy.find("name the chip in target.gpio_chip") ==
          0);
    CHECK(judge_line("k", "TWICE", lines_called(seen, "TWICE", "")).remedy.find("give one of them another name") ==
          0);
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
