/* Samples of how long something takes, and what is told of them. */
#ifndef TESTS_BENCH_TIMED_H
#define TESTS_BENCH_TIMED_H

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

/* How often a motion is gone through from its start. It is the same motion every time: the least of a tick's times
 * is the tick's own, what is more came from outside, such as the time that a virtual machine is not given. */
constexpr int passes = 5;

struct timed {
    std::string name;
    std::vector<double> ns{};    /* of all */
    std::vector<double> least{}; /* of each tick */

    template <class Work>
    void once(std::size_t tick, const Work &work)
    {
        const auto from = std::chrono::steady_clock::now();
        work();
        const double took =
            std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - from).count();
        ns.push_back(took);
        if (tick == least.size()) {
            least.push_back(took);
        }
        least[tick] = std::min(least[tick], took);
    }
};

inline double at_share(std::vector<double> values, double share)
{
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/* One JSON object. */
inline void print_timed(const std::vector<const timed *> &all)
{
    for (const timed *one : all) {
        std::printf("%s\"%s\": {\"median_ns\": %.0f, \"p99.9_ns\": %.0f, \"least_median_ns\": %.0f, "
                    "\"least_p99.9_ns\": %.0f}",
                    one == all.front() ? "{" : ", ", one->name.c_str(), at_share(one->ns, 0.5),
                    at_share(one->ns, 0.999), at_share(one->least, 0.5), at_share(one->least, 0.999));
    }
    std::printf("}\n");
}

#endif
