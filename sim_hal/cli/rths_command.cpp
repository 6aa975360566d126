#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../rths/benchmark.h"
#include "atomic_file.h"
#include "commands.h"
#include "progress_line.h"

namespace berth
{

namespace
{

using rths::criteria;

constexpr double earthquake_scale = 0.4;
constexpr std::array<const char *, rths::criteria_count> names = {"J1_ms",      "J2_percent", "J3_percent",
                                                                  "J4_percent", "J5_percent", "J6_percent",
                                                                  "J7_percent", "J8_percent", "J9_percent"};

/* Rows that others got with the benchmark's own noise and plants, recomputed: El Centro. */
struct published_row {
    const char *name;
    const char *controller; /* ours that must give the same; empty: none does */
    int building_case;
    int perturbed; /* 0: the nominal plant; else the worst of so many */
    criteria value;
};

constexpr published_row published[] = {
    {"PI with phase lead", "pi", 1, 0, {4.64, 10.37, 11.56, 36.0, 18.4, 32.2, 32.3, 14.8, 14.8}},
    {"PI with phase lead", "pi", 4, 0, {4.64, 10.46, 11.41, 72.5, 35.5, 68.5, 68.6, 33.4, 33.3}},
    {"third-order inverse", "inverse", 1, 0, {4.64, 10.48, 11.09, 34.2, 17.3, 31.3, 31.3, 14.7, 14.6}},
    {"adaptive model-based", "", 1, 0, {0.0, 2.55, 2.17, 3.19, 2.45, 1.85, 1.85, 1.10, 1.09}},
    {"adaptive model-based", "", 4, 0, {0.0, 1.98, 1.92, 3.64, 2.86, 3.01, 3.02, 1.51, 1.50}},
    {"adaptive model-based", "", 1, 20, {0.0, 2.56, 2.19, 3.24, 2.49, 1.92, 1.93, 1.16, 1.15}},
};

/* To be looked at beside this run: the same controller's, and the best one. */
std::vector<published_row> rows_beside(const rths_arguments &arguments)
{
    std::vector<published_row> rows;
    for (const published_row &row : published) {
        const bool is_same_or_best = row.controller == arguments.controller || *row.controller == '\0';
        if (arguments.earthquake == "el_centro" && row.building_case == arguments.building_case && is_same_or_best) {
            rows.push_back(row);
        }
    }
    return rows;
}

struct judged_run {
    criteria value{};
    rths::noise_share noise{};
};

struct benchmark_result {
    judged_run nominal;
    std::vector<judged_run> perturbed;
    criteria worst{};
};

void write_samples(const std::string &path, const rths::run_record &record)
{
    atomic_file file(path);
    file.write(
        "t_s,command_m,measured_m,measured_N,true_m,true_N,simulated_1_m,simulated_2_m,simulated_3_m,reference_1_m,"
        "reference_2_m,reference_3_m\n");
    for (std::size_t n = 0; n < record.command_m.size(); n++) {
        char line[320];
        std::snprintf(line, sizeof line, "%.12g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n",
                      rths::period_s * static_cast<double>(n), record.command_m[n], record.measured_m[n],
                      record.measured_N[n], record.true_m[n], record.true_N[n], record.simulated_m[0][n],
                      record.simulated_m[1][n], record.simulated_m[2][n], record.reference_m[0][n],
                      record.reference_m[1][n], record.reference_m[2][n]);
        file.write(line);
    }
    file.finish();
}

judged_run judged(const rths::run_record &record)
{
    return {rths::judge(record), rths::noise_alone(record)};
}

rths::building read_frame(const std::string &path)
{
    rths::building all = rths::read_building(path);
    const rths::transfer_parameters specimen;
    if (all.mass_kg(0, 0) <= specimen.specimen_mass_kg ||
        all.stiffness_N_per_m(0, 0) <= specimen.specimen_stiffness_N_per_m ||
        all.damping_N_s_per_m(0, 0) <= specimen.specimen_damping_N_s_per_m()) {
        throw input_error(path +
                          ": the first floor is not heavier, stiffer and more damped than the specimen in it");
    }
    return all;
}

benchmark_result run_all(const rths_arguments &arguments)
{
    const std::string folder = arguments.data_folder + "/";
    const rths::building all = read_frame(folder + "case_" + std::to_string(arguments.building_case) + ".txt");
    const rths::ground_motion ground(folder + arguments.earthquake + ".csv.gz", earthquake_scale);
    const auto run = [&](const rths::transfer_parameters &hardware, std::int64_t seed) {
        const auto controller = rths::make_controller(arguments.controller, {all, {}, arguments.force_age_samples});
        return rths::run_benchmark(all, ground, hardware, *controller, {seed, arguments.noise});
    };
    benchmark_result result;
    const rths::run_record nominal = run({}, arguments.seed);
    result.nominal = judged(nominal);
    if (!arguments.samples_file.empty()) {
        write_samples(arguments.samples_file, nominal);
    }
    const progress_line progress;
    for (int plant = 1; plant <= arguments.perturbed; plant++) {
        progress.show("rths: plant " + std::to_string(plant) + " of " + std::to_string(arguments.perturbed));
        const std::int64_t seed = arguments.seed + plant;
        result.perturbed.push_back(judged(run(rths::perturbed(seed), seed)));
        for (std::size_t j = 0; j < result.worst.size(); j++) {
            result.worst[j] = std::max(result.worst[j], result.perturbed.back().value[j]);
        }
    }
    return result;
}

nlohmann::json as_json(const criteria &value)
{
    nlohmann::json json;
    for (std::size_t j = 0; j < value.size(); j++) {
        json[names[j]] = value[j];
    }
    return json;
}

nlohmann::json as_json(const judged_run &run)
{
    nlohmann::json json = as_json(run.value);
    json["noise_floor_percent"] = run.noise.spread_percent;
    json["noise_peak_percent"] = run.noise.peak_percent;
    return json;
}

nlohmann::json as_json(const rths_arguments &arguments, const benchmark_result &result)
{
    nlohmann::json json = {{"earthquake", arguments.earthquake}, {"case", arguments.building_case},
                           {"controller", arguments.controller}, {"seed", arguments.seed},
                           {"noise", arguments.noise},           {"force_age_samples", arguments.force_age_samples},
                           {"nominal", as_json(result.nominal)}, {"published", nlohmann::json::array()}};
    if (!result.perturbed.empty()) {
        json["worst_of_perturbed"] = as_json(result.worst);
        for (const judged_run &run : result.perturbed) {
            json["perturbed"].push_back(as_json(run));
        }
    }
    for (const published_row &row : rows_beside(arguments)) {
        nlohmann::json one = as_json(row.value);
        one["name"] = row.name;
        one["worst_of"] = row.perturbed;
        one["is_this_controller"] = row.controller == arguments.controller;
        json["published"].push_back(one);
    }
    return json;
}

void print_row(const std::string &name, const criteria &value)
{
    std::printf("%-46s", name.c_str());
    for (const double figure : value) {
        std::printf(" %7.2f", figure);
    }
    std::printf("\n");
}

std::string worst_of(int plants)
{
    return plants > 0 ? ", worst of " + std::to_string(plants) + " plants" : "";
}

void print_table(const rths_arguments &arguments, const benchmark_result &result)
{
    std::printf("%s, case %d, seed %lld\n", arguments.earthquake.c_str(), arguments.building_case,
                static_cast<long long>(arguments.seed));
    std::printf("%-46s   J1 ms    J2 %%    J3 %%    J4 %%    J5 %%    J6 %%    J7 %%    J8 %%    J9 %%\n", "");
    print_row(arguments.controller, result.nominal.value);
    if (arguments.perturbed > 0) {
        print_row(arguments.controller + worst_of(arguments.perturbed), result.worst);
    }
    for (const published_row &row : rows_beside(arguments)) {
        print_row("published: " + (row.name + worst_of(row.perturbed)), row.value);
    }
    std::printf("the sensor's noise alone: J2 %.2f %%, J3 %.2f %%\n", result.nominal.noise.spread_percent,
                result.nominal.noise.peak_percent);
    double peak_percent = 0.0;
    for (const judged_run &run : result.perturbed) {
        peak_percent = std::max(peak_percent, run.noise.peak_percent);
    }
    if (!result.perturbed.empty()) {
        std::printf("and where it is worst of these plants: J3 %.2f %%\n", peak_percent);
    }
}

} // namespace

int rths_command(const rths_arguments &arguments)
{
    const benchmark_result result = run_all(arguments);
    if (arguments.json) {
        print_json(as_json(arguments, result));
    } else {
        print_table(arguments, result);
    }
    return 0;
}

} // namespace berth
