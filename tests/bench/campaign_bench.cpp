/* One process that builds and solves rigs: what a campaign's time per sample is compared with.
 *
 *   campaign_bench FILE RIG KEY...     FILE: doubles, one row of a value for each key; prints ns per rig of both
 * ways */
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "../../sim_hal/berth.h"

namespace
{

using seconds = std::chrono::duration<double>;

std::vector<double> read_doubles(const char *path)
{
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    const auto *const first = reinterpret_cast<const double *>(bytes.data());
    return {first, first + bytes.size() / sizeof(double)};
}

} // namespace

int main(int argc, char **argv)
{
    if (argc < 4) {
        std::fprintf(stderr, "usage: campaign_bench FILE RIG KEY...\n");
        return 2;
    }
    const std::vector<std::string> keys(argv + 3, argv + argc);
    const std::vector<double> values = read_doubles(argv[1]);
    const std::size_t rigs = values.size() / keys.size();
    double sum_per_s = 0.0;

    /* Built in place: the rig is copied, its keys set, completed and checked. */
    const auto begin = std::chrono::steady_clock::now();
    for (const double growth_per_s :
         growth_of_varied(berth::load_rig(argv[2]), keys, values.data(), rigs).growth_per_s) {
        sum_per_s += growth_per_s;
    }
    const auto in_place = std::chrono::steady_clock::now();

    /* Built as the command does it, from the file's text: a tenth of them. */
    const std::size_t few = rigs / 10 + 1;
    for (std::size_t i = 0; i < few && i < rigs; i++) {
        std::vector<std::string> settings;
        for (std::size_t j = 0; j < keys.size(); j++) {
            char text[64];
            std::snprintf(text, sizeof text, "=%.17g", values[i * keys.size() + j]);
            settings.push_back(keys[j] + text);
        }
        sum_per_s += berth::loop_spectrum(berth::load_rig(argv[2], settings)).growth_per_s;
    }
    const auto read_anew = std::chrono::steady_clock::now();
    std::printf("%zu rigs: %.0f ns in place, %.0f ns read anew; sum %.17g\n", rigs,
                1e9 * seconds(in_place - begin).count() / static_cast<double>(rigs),
                1e9 * seconds(read_anew - in_place).count() / static_cast<double>(few), sum_per_s);
    return 0;
}
