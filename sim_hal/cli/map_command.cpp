#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <unistd.h>

#include "../stability/lyapunov.h"
#include "../stability/varying_map.h"
#include "atomic_file.h"
#include "map_request.h"

namespace berth
{

namespace
{

/* Above this many points the user is asked. */
constexpr std::size_t large_map_points = 10000000;
constexpr std::size_t row_bytes = 75; /* of a CSV line, about */

/* Above this time, too, where each point is a sequence of ticks. */
constexpr double long_map_s = 600.0;

/* Of each point's sequence, if nobody says: enough ticks for the scatter, enough time for the modes to part. */
constexpr std::int64_t default_ticks = 8000;
constexpr std::int64_t default_duration_s = 20;

/* A request, and what makes the loop change from tick to tick, if anything does. */
struct map_job {
    map_request request; /* of the loop that does not change */
    std::optional<map_request> varying;
    wake_histogram histogram;
    std::int64_t ticks = 0;
};

/* What it amounts to. */
struct map_values {
    map_result steady;
    std::vector<double> exponents; /* none if the loop does not change */
};

void append(std::string &line, double value, char end)
{
    char digits[32];
    const char *const last = std::to_chars(digits, digits + sizeof digits, value).ptr;
    if (std::isnan(value)) { /* without a sign, which would be chance */
        line += "nan";
    } else {
        line.append(digits, static_cast<std::size_t>(last - digits));
    }
    line += end;
}

struct summary {
    std::size_t possible = 0;
    std::size_t not_passive = 0;
    std::size_t invalid = 0;
    std::size_t stable = 0;
    std::size_t below_wall = 0;
    std::size_t stable_below_wall = 0;
    std::size_t stable_varying = 0;
    std::size_t stable_varying_below_wall = 0;
    std::size_t lost = 0;   /* stable, and not so where the loop changes */
    std::size_t gained = 0; /* the other way round */
    double least = std::numeric_limits<double>::infinity();
    double largest = 0.0;
};

/* Hands the lines of the CSV file to `write`, row by row; returns what they amount to. */
summary write_csv(const map_request &request, const map_values &map,
                  const std::function<void(std::string_view)> &write)
{
    summary sums;
    const bool varies = !map.exponents.empty();
    write(request.x.name + "," + request.y.name + ",spectral_radius,growth_per_s,wall" +
          (varies ? ",lyapunov_per_s\n" : "\n"));
    std::string lines;
    map_point_setter setter(request);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const double *value = map.steady.spectral_radius.data();
    const double *exponent = map.exponents.data();
    for (int row = 0; row < request.y.count; row++) {
        const double y = request.y.value(row);
        lines.clear();
        for (int i = 0; i < request.x.count; i++) {
            const double x = request.x.value(i);
            const double radius = *value++;
            const point_state state = setter.set(x, y);
            double growth_per_s = nan;
            double wall = nan;
            if (state == point_state::possible) {
                const bool is_below = coupled_damped_frequency_Hz(setter.rig()) < wall_Hz;
                wall = is_below ? 1.0 : 0.0;
                growth_per_s = std::log(radius) / config_period_s(&setter.rig().firmware);
                sums.possible++;
                sums.below_wall += is_below;
                sums.stable += radius < 1.0;
                sums.stable_below_wall += is_below && radius < 1.0;
                sums.least = std::min(sums.least, radius);
                sums.largest = std::max(sums.largest, radius);
                if (varies) {
                    const bool is_stable = *exponent < 0.0;
                    sums.stable_varying += is_stable;
                    sums.stable_varying_below_wall += is_below && is_stable;
                    sums.lost += radius < 1.0 && !is_stable;
                    sums.gained += radius >= 1.0 && is_stable;
                }
            } else {
                (state == point_state::invalid ? sums.invalid : sums.not_passive)++;
            }
            append(lines, x, ',');
            append(lines, y, ',');
            append(lines, radius, ',');
            append(lines, growth_per_s, ',');
            append(lines, wall, varies ? ',' : '\n');
            if (varies) {
                append(lines, *exponent++, '\n');
            }
        }
        write(lines);
    }
    return sums;
}

/* Of all threads, so far. */
double cpu_s()
{
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

class progress_bar
{
  public:
    explicit progress_bar(int rows) : rows_(rows), is_shown_(isatty(STDERR_FILENO) != 0) {}

    void show(int done)
    {
        const auto now = std::chrono::steady_clock::now();
        if (!is_shown_ || now - shown_ < std::chrono::milliseconds(100)) {
            return;
        }
        shown_ = now;
        constexpr int width = 40;
        const int filled = static_cast<int>(static_cast<long>(width) * done / rows_);
        std::fprintf(stderr, "\r[%s%s] %d of %d rows", std::string(static_cast<std::size_t>(filled), '#').c_str(),
                     std::string(static_cast<std::size_t>(width - filled), ' ').c_str(), done, rows_);
        was_shown_ = true;
    }
    void clear() const
    {
        if (was_shown_) {
            std::fprintf(stderr, "\r%-80s\r", "");
        }
    }

  private:
    int rows_;
    bool is_shown_;
    bool was_shown_ = false;
    std::chrono::steady_clock::time_point shown_ = std::chrono::steady_clock::now();
};

void ask_if_large(const map_request &request, int threads, bool yes)
{
    if (request.points() <= large_map_points || yes) {
        return;
    }
    /* The map itself with all threads, its file with one. */
    const map_request sample = sample_of(request);
    const auto start = std::chrono::steady_clock::now();
    const map_values map{compute_map(sample, 1), {}};
    const auto computed = std::chrono::steady_clock::now();
    write_csv(sample, map, [](std::string_view) {});
    const std::chrono::duration<double> compute = computed - start;
    const std::chrono::duration<double> write = std::chrono::steady_clock::now() - computed;
    const double duration_s = (compute.count() / threads + write.count()) * static_cast<double>(request.points()) /
                              static_cast<double>(sample.points());
    const double points = static_cast<double>(request.points());
    char text[300];
    std::snprintf(
        text, sizeof text,
        "map: %.3g points take about %.0f s on %d thread%s, %.1f GB of memory and %.1f GB of disk; say --yes "
        "to go on",
        points, std::ceil(duration_s), threads, threads == 1 ? "" : "s",
        points * static_cast<double>(sizeof(double)) / 1e9, points * static_cast<double>(row_bytes) / 1e9);
    throw input_error(text);
}

/* Time that the exponents take, from a few points in the middle of rows; asks if it is very long. */
double estimate_s(const map_job &job, int threads, bool yes)
{
    constexpr int points_a_side = 4;
    map_request sample = *job.varying;
    for (map_axis *const axis : {&sample.x, &sample.y}) {
        axis->count = std::min(axis->count, points_a_side);
    }
    const auto start = std::chrono::steady_clock::now();
    compute_varying_map(sample, job.histogram, job.ticks, 1);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    const double duration_s = taken.count() * static_cast<double>(job.varying->points()) /
                              static_cast<double>(sample.points() * static_cast<std::size_t>(threads));
    if (duration_s > long_map_s && !yes) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "map: %zu points over %lld ticks each take about %.0f s on %d thread%s; say --yes to go on",
                      job.varying->points(), static_cast<long long>(job.ticks), std::ceil(duration_s), threads,
                      threads == 1 ? "" : "s");
        throw input_error(text);
    }
    return duration_s;
}

nlohmann::json axis_json(const map_axis &axis)
{
    return {{"name", axis.name}, {"from", axis.from}, {"to", axis.to}, {"count", axis.count}};
}

double value_of(const rig &rig, const std::string &name)
{
    if (const rig_key *const key = find_key(name)) {
        void *const member = key->member(const_cast<berth::rig &>(rig));
        return key->type == key_type::integer ? static_cast<double>(*static_cast<std::int64_t *>(member))
                                              : *static_cast<double *>(member);
    }
    const map_point point = map_point_of(rig);
    return name == frequency_ratio_axis ? point.frequency_ratio : point.damping_ratio;
}

nlohmann::json as_json(const map_job &job, const summary &sums)
{
    const map_request &request = job.request;
    const spectrum own = loop_spectrum(request.rig);
    const manipulator_config &arm = request.rig.firmware.manipulator;
    const double arm_Hz = std::sqrt(arm.stiffness_N_per_m / arm.mass_kg) / 6.28318530717958647692;
    const auto share = [](std::size_t part, std::size_t of) {
        return of > 0 ? nlohmann::json(static_cast<double>(part) / static_cast<double>(of)) : nlohmann::json();
    };
    const bool has_points = sums.possible > 0;
    nlohmann::json json = {{"rig", request.rig.name},
                           {"vary", request.kind == map_kind::mass         ? nlohmann::json("mass")
                                    : request.kind == map_kind::elasticity ? nlohmann::json("elasticity")
                                                                           : nlohmann::json()},
                           {"axes", {{"x", axis_json(request.x)}, {"y", axis_json(request.y)}}},
                           {"points", request.points()},
                           {"points_possible", sums.possible},
                           {"points_not_passive", sums.not_passive},
                           {"points_invalid", sums.invalid},
                           {"stable_share", share(sums.stable, sums.possible)},
                           {"stable_share_below_wall", share(sums.stable_below_wall, sums.below_wall)},
                           {"wall_Hz", wall_Hz},
                           {"manipulator_Hz", arm_Hz},
                           {"spectral_radius_min", has_points ? nlohmann::json(sums.least) : nlohmann::json()},
                           {"spectral_radius_max", has_points ? nlohmann::json(sums.largest) : nlohmann::json()},
                           {"own",
                            {{"x", value_of(request.rig, request.x.name)},
                             {"y", value_of(request.rig, request.y.name)},
                             {"spectral_radius", own.spectral_radius},
                             {"growth_per_s", own.growth_per_s},
                             {"stable", own.is_stable}}}};
    if (job.varying) {
        const rig &rig = job.varying->rig;
        const lyapunov_exponent exponent = exponent_of(rig, job.histogram);
        json["varying"] = {{"varies", what_varies(rig, job.histogram)},
                           {"ticks", job.ticks},
                           {"seed", rig.run.seed},
                           {"stable_share", share(sums.stable_varying, sums.possible)},
                           {"stable_share_below_wall", share(sums.stable_varying_below_wall, sums.below_wall)},
                           {"lost_share_of_stable", share(sums.lost, sums.stable)},
                           {"gained_share_of_stable", share(sums.gained, sums.stable)},
                           {"own_growth_per_s", exponent.growth_per_s},
                           {"own_growth_ci95_per_s", exponent.ci95_per_s}};
    }
    return json;
}

void print_for_a_person(const map_request &request, const summary &sums, const nlohmann::json &json)
{
    const auto percent = [](std::size_t part, std::size_t of) {
        return of > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(of) : 0.0;
    };
    std::printf("%s: %s from %g to %g, %s from %g to %g\n", request.rig.name.c_str(), axis_title(request.x).c_str(),
                request.x.from, request.x.to, axis_title(request.y).c_str(), request.y.from, request.y.to);
    std::printf("  %zu points, %.1f %% of the possible stable, %.1f %% of those below the %g Hz wall\n",
                request.points(), percent(sums.stable, sums.possible),
                percent(sums.stable_below_wall, sums.below_wall), wall_Hz);
    if (json.contains("varying")) {
        for (const nlohmann::json &effect : json["varying"]["varies"]) {
            std::printf("  %s:\n", effect.get<std::string>().c_str());
        }
        std::printf("    %.1f %% stable, %.1f %% of those below the wall; %.2f %% of the stable area lost, %.2f %% "
                    "gained\n",
                    percent(sums.stable_varying, sums.possible),
                    percent(sums.stable_varying_below_wall, sums.below_wall), percent(sums.lost, sums.stable),
                    percent(sums.gained, sums.stable));
    }
    if (sums.not_passive > 0) {
        std::printf("  %zu points left out (nan): they need a negative stiffness, damping or mass of the object\n",
                    sums.not_passive);
    }
    if (sums.invalid > 0) {
        std::printf("  %zu points left out (nan): there the rig is not valid\n", sums.invalid);
    }
    if (sums.possible > 0) {
        std::printf("  largest |z| from %.9f to %.9f\n", sums.least, sums.largest);
    }
    std::printf("  the rig itself: %s = %g, %s = %g, largest |z| %.9f\n", axis_title(request.x).c_str(),
                json["own"]["x"].get<double>(), axis_title(request.y).c_str(), json["own"]["y"].get<double>(),
                json["own"]["spectral_radius"].get<double>());
    std::printf("  %.3f s for the map\n", json["compute_s"].get<double>());
}

map_job make_job(const map_arguments &arguments)
{
    map_job job{make_map_request(arguments), {}, {}, arguments.ticks};
    if (job.ticks == 0) {
        job.ticks = std::max(default_ticks, default_duration_s * job.request.rig.firmware.loop.rate_Hz);
    }
    if (is_time_varying(job.request.rig)) {
        job.varying = job.request;
        job.histogram = load_wake_histogram(job.request.rig);
        job.request.rig = without_variation(job.request.rig);
    }
    return job;
}

map_values compute(const map_job &job, int threads)
{
    progress_bar bar(job.request.y.count);
    const auto show = [&](int rows) { bar.show(rows); };
    map_values map{compute_map(job.request, threads, show), {}};
    if (job.varying) {
        map.exponents = compute_varying_map(*job.varying, job.histogram, job.ticks, threads, show);
    }
    bar.clear();
    return map;
}

} // namespace

int map_command(const map_arguments &arguments)
{
    const map_job job = make_job(arguments);
    const map_request &request = job.request;
    const int threads = arguments.threads > 0 ? arguments.threads
                                              : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    ask_if_large(request, threads, arguments.yes);
    if (job.varying) {
        const double duration_s = estimate_s(job, threads, arguments.yes);
        if (!arguments.json) {
            std::fprintf(stderr, "%zu points over %lld ticks each: about %.0f s\n", request.points(),
                         static_cast<long long>(job.ticks), std::ceil(duration_s));
        }
    }

    std::error_code error;
    std::filesystem::create_directories(arguments.out_folder, error);
    if (error) {
        throw input_error(arguments.out_folder + ": cannot be made: " + error.message());
    }
    const auto start = std::chrono::steady_clock::now();
    const double cpu_start_s = cpu_s();
    const map_values map = compute(job, threads);
    const double cpu_taken_s = cpu_s() - cpu_start_s;
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;

    const std::string what = request.kind == map_kind::keys ? request.x.name + "-" + request.y.name : arguments.vary;
    const std::string stem = arguments.out_folder + "/" + request.rig.name + "-" + what;
    atomic_file csv(stem + ".csv");
    const summary sums = write_csv(request, map, [&](std::string_view text) { csv.write(text); });
    csv.finish();
    nlohmann::json json = as_json(job, sums);
    atomic_file beside(stem + ".json");
    beside.write(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    beside.finish();
    json["csv"] = stem + ".csv";
    json["compute_s"] = taken.count();
    json["compute_cpu_s"] = cpu_taken_s;
    json["threads"] = threads;
    json["searches"] = map.steady.searches;
    if (arguments.json) {
        print_json(json);
        return 0;
    }
    print_for_a_person(request, sums, json);
    std::printf("map       %s.csv\npicture   .venv/bin/python scripts/map_picture.py %s.csv\n", stem.c_str(),
                stem.c_str());
    return 0;
}

} // namespace berth
