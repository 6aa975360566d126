/* Samples of how long something takes, and what is told of them. */
#ifndef TESTS_BENCH_TIMED_H
#define TESTS_BENCH_TIMED_H

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

struct timed {
    std::string name;
    std::vector<double> ns;

    template <class Work>
    void once(const Work &work)
    {
        const auto from = std::chrono::steady_clock::now();
        work();
        ns.push_back(std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - from).count());
    }

    double at_share(double share) const
    {
        std::vector<double> sorted = ns;
        std::sort(sorted.begin(), sorted.end());
        return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
    }
};

/* One JSON object. */
inline void print_timed(const std::vector<const timed *> &all)
{
    for (const timed *one : all) {
        std::printf("%s\"%s\": {\"median_ns\": %.0f, \"p99.9_ns\": %.0f}", one == all.front() ? "{" : ", ",
                    one->name.c_str(), one->at_share(0.5), one->at_share(0.999));
    }
    std::printf("}\n");
}

#endif
