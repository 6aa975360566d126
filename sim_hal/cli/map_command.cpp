#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <thread>
#include <unistd.h>

#include "../../firmware/compensation/compensation.h"
#include "../../hal/rig/given.h"
#include "../bounce.h"
#include "../stability/arm_loop.h"
#include "../stability/loop_timeline.h"
#include "../stability/reduction.h"
#include "../stability/shared_rows.h"
#include "atomic_file.h"
#include "map_report.h"
#include "python_script.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

/* Above this many points the user is asked. */
constexpr std::size_t large_map_points = 10000000;
constexpr double row_bytes = 75; /* of a CSV line, about */
constexpr double value_bytes = 19;

/* Above this time, too, where each point is a sequence of ticks. */
constexpr double long_map_s = 600.0;

/* At an amplitude: from here on it is said how long it takes. A sample of them takes seconds. */
constexpr std::size_t slow_map_points = 10000;

/* Of each point's sequence, if nobody says: enough ticks for the scatter, enough time for the modes to part. */
constexpr std::int64_t default_ticks = 8000;
constexpr double default_duration_s = 20.0;

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

/* The maps of a loop that does not change. */
map_values compute_steady(const map_job &job, int threads, const std::function<void(int)> &rows_done = {})
{
    map_values map{compute_map(job.request, threads, rows_done), {}, {}, {}, {}, {}};
    if (job.request.rig.firmware.arm.kind != ARM_NONE && !compensation_is_on(&job.request.rig.firmware)) {
        try {
            map_request reduced = job.request;
            reduced.reduced_to = arm_at_start(job.request.rig);
            map.reduced = compute_map(reduced, threads);
        } catch (const nothing_springy &) {
            map.reduced.reset(); /* there is nothing that it could be reduced to */
        }
    }
    if (job.lower_end) {
        map.lower_end = compute_map(*job.lower_end, threads, rows_done);
    }
    return map;
}

/* The map itself with all threads, its file with one. */
double estimate_steady_s(const map_job &job, int threads)
{
    map_job sample;
    sample.request = sample_of(job.request);
    if (job.lower_end) {
        sample.lower_end = sample_of(*job.lower_end);
    }
    const auto start = std::chrono::steady_clock::now();
    const map_values map = compute_steady(sample, 1);
    const auto computed = std::chrono::steady_clock::now();
    write_csv(sample.request, map, [](std::string_view) {});
    const std::chrono::duration<double> compute = computed - start;
    const std::chrono::duration<double> write = std::chrono::steady_clock::now() - computed;
    return (compute.count() / threads + write.count()) * static_cast<double>(job.request.points()) /
           static_cast<double>(sample.request.points());
}

/* Points at an amplitude take a thousand times longer than others. */
void ask_if_large(const map_job &job, int threads, const map_arguments &arguments)
{
    const map_request &request = job.request;
    const bool has_amplitude = request.amplitude_m > 0.0 && request.points() > slow_map_points;
    if (arguments.yes || !(request.points() > large_map_points || has_amplitude)) {
        return;
    }
    const double duration_s = estimate_steady_s(job, threads);
    if (request.points() <= large_map_points && duration_s <= long_map_s) {
        if (!arguments.json) {
            std::fprintf(stderr, "%zu points at an amplitude: about %.0f s\n", request.points(),
                         std::ceil(duration_s));
        }
        return;
    }
    const double points = static_cast<double>(request.points());
    const double more_values = (job.lower_end ? 1.0 : 0.0) + (job.varying ? 1.0 : 0.0);
    char text[300];
    std::snprintf(
        text, sizeof text,
        "map: %.3g points take about %.0f s on %d thread%s, %.1f GB of memory and %.1f GB of disk; say --yes "
        "to go on",
        points, std::ceil(duration_s), threads, threads == 1 ? "" : "s",
        (1.0 + more_values) * points * static_cast<double>(sizeof(double)) / 1e9,
        points * (row_bytes + more_values * value_bytes) / 1e9);
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

/* Asks if it is very long; from three points on a diagonal. */
void ask_if_long(const map_job &job, int threads, bool yes)
{
    constexpr int sampled = 3;
    map_point_setter setter(job.request);
    const auto start = std::chrono::steady_clock::now();
    for (int i = 1; i <= sampled; i++) {
        const map_axis &x = job.request.x;
        const map_axis &y = job.request.y;
        if (setter.set(x.value(i * (x.count - 1) / (sampled + 1)), y.value(i * (y.count - 1) / (sampled + 1))) ==
            point_state::possible) {
            setter.for_each_model([&](const rig &told) { measure(told, job.run_s); });
        }
    }
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    const double duration_s =
        taken.count() / sampled * static_cast<double>(job.request.points()) / static_cast<double>(threads);
    if (duration_s > long_map_s && !yes) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "map: %zu points, each run for %g s, take about %.0f s on %d thread%s; say --yes to go on",
                      job.request.points(), job.run_s, std::ceil(duration_s), threads, threads == 1 ? "" : "s");
        throw input_error(text);
    }
}

map_job make_job(const map_arguments &arguments)
{
    constexpr const char *dead_time = "robot.dead_time_ms"; /* as an axis, it has no range at a point */
    map_job job;
    job.chosen = choose_rig(arguments);
    refuse_unstated(job.chosen.rig, arguments.rig);
    job.request = make_map_request(arguments, job.chosen.rig);
    job.bounces = job.chosen.rig.object.kind == object_kind::contact && !is_measured(arguments, job.chosen.rig) &&
                  job.request.amplitude_m == 0.0 && job.chosen.rig.firmware.arm.kind == ARM_NONE;
    job.request.has_flight = job.bounces;
    const rig &rig = job.request.rig;
    job.ticks = arguments.ticks > 0 ? arguments.ticks
                                    : std::max(default_ticks, static_cast<std::int64_t>(std::llround(
                                                                  default_duration_s * rig.firmware.loop.rate_Hz)));
    if (is_measured(arguments, rig)) {
        job.run_s = arguments.ticks > 0 ? static_cast<double>(arguments.ticks) / rig.firmware.loop.rate_Hz
                                        : default_duration_s;
        return job;
    }
    const std::vector<berth::rig> corners = corners_of(job.request);
    if (std::any_of(corners.begin(), corners.end(), is_time_varying)) {
        job.varying = job.request;
        job.histogram = load_wake_histogram(rig);
        job.request.rig = without_variation(rig);
    }
    if (job.chosen.dead_time_band && job.request.x.name != dead_time && job.request.y.name != dead_time) {
        job.lower_end = job.request;
        show_dead_time(job.lower_end->rig, job.chosen.dead_time_band->from);
    }
    return job;
}

const std::string nothing_to_see = "map: nothing to be seen, none of its points is a loop: ";

void refuse_if_none_is_possible(const map_request &request)
{
    map_point_setter setter(request);
    for (int row = 0; row < request.y.count; row++) {
        for (int i = 0; i < request.x.count; i++) {
            if (setter.set(request.x.value(i), request.y.value(row)) == point_state::possible) {
                return;
            }
        }
    }
    if (setter.set(request.x.value(0), request.y.value(0)) == point_state::not_passive) {
        throw input_error(
            nothing_to_see +
            "the first needs a negative stiffness, damping or mass of the object; choose other ranges");
    }
    rig refused = setter.rig();
    const auto error = complete_and_check(refused);
    throw input_error(nothing_to_see + "at the first " + error->key + ": " + error->message);
}

/* With the |z| that a linear loop would have that grows like this. */
map_values compute_measured(const map_job &job, int threads, const std::function<void(int)> &rows_done)
{
    const map_request &request = job.request;
    map_values map;
    map.measured = compute_measured_map(request, job.run_s, threads, rows_done);
    map_point_setter setter(request);
    for (std::size_t i = 0; i < map.measured.size(); i++) {
        const auto columns = static_cast<std::size_t>(request.x.count);
        setter.set(request.x.value(static_cast<int>(i % columns)), request.y.value(static_cast<int>(i / columns)));
        const double period_s = config_period_s(&setter.rig().firmware);
        map.steady.spectral_radius.push_back(std::exp(map.measured[i].growth_per_s * period_s));
    }
    return map;
}

/* Each point's tool bounces once. */
std::vector<double> compute_restitutions(const map_request &request, int threads,
                                         const std::function<void(int)> &rows_done)
{
    std::vector<double> found(request.points(), std::numeric_limits<double>::quiet_NaN());
    share_rows(request.y.count, threads, rows_done, [&] {
        return [&, setter = map_point_setter(request)](int row) mutable {
            for (int i = 0; i < request.x.count; i++) {
                if (setter.set(request.x.value(i), request.y.value(row)) != point_state::possible) {
                    continue;
                }
                double &highest = found[static_cast<std::size_t>(row) * static_cast<std::size_t>(request.x.count) +
                                        static_cast<std::size_t>(i)];
                setter.for_each_loop([&](rig touching) {
                    touching.object.kind = object_kind::contact;
                    const auto bounce = play_bounce(touching);
                    if (bounce && bounce->restitution > 0.0 && !(highest > bounce->restitution)) {
                        highest = bounce->restitution;
                    }
                });
            }
        };
    });
    return found;
}

map_values compute(const map_job &job, int threads)
{
    progress_bar bar(job.request.y.count);
    const auto show = [&](int rows) { bar.show(rows); };
    if (job.run_s > 0.0) {
        map_values map = compute_measured(job, threads, show);
        bar.clear();
        return map;
    }
    map_values map = compute_steady(job, threads, show);
    if (job.bounces) {
        map.restitution = compute_restitutions(job.request, threads, show);
    }
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
    refuse_if_none_is_possible(request);
    if (job.varying) {
        refuse_arm(request.rig);
    }
    if (job.run_s == 0.0 && request.rig.firmware.arm.kind != ARM_NONE) {
        spectral_radius_of(request.rig); /* throws where an arm has none */
    }
    for (const std::string &line : left_out_of_map(job)) {
        std::fprintf(stderr, "berth: %s\n", line.c_str());
    }
    const int threads = arguments.threads > 0 ? arguments.threads
                                              : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    if (job.run_s > 0.0) {
        ask_if_long(job, threads, arguments.yes);
    } else {
        ask_if_large(job, threads, arguments);
    }
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
    const std::string robot = job.chosen.robot ? "-" + job.chosen.robot->name : "";
    const std::string stem = arguments.out_folder + "/" + request.rig.name + robot + "-" + what;
    atomic_file csv(stem + ".csv");
    const map_summary sums = write_csv(request, map, [&](std::string_view text) { csv.write(text); });
    if (sums.steady.possible == 0) {
        throw input_error(
            nothing_to_see +
            "they are like no linear loop at this amplitude (a spring that softens to nothing?); choose "
            "a smaller --amplitude or other ranges");
    }
    csv.finish();
    nlohmann::json json = as_json(job, sums);
    json["assumed"] = assumed_json(job.chosen.rig);
    json["delay_budget"] = delay_budget_json(job.chosen.rig);
    atomic_file beside(stem + ".json");
    beside.write(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    beside.finish();
    json["csv"] = stem + ".csv";
    json["picture"] = nullptr;
    if (arguments.picture) {
        const int exit_code =
            run_script("map_picture.py", "map: draws " + stem + ".png", {stem + ".csv", "--quiet"});
        if (exit_code != 0) {
            return exit_code;
        }
        json["picture"] = stem + ".png";
    }
    json["compute_s"] = taken.count();
    json["compute_cpu_s"] = cpu_taken_s;
    json["threads"] = threads;
    json["searches"] = map.steady.searches + (map.lower_end ? map.lower_end->searches : 0);
    if (arguments.json) {
        print_json(json);
        return 0;
    }
    print_assumptions(job.chosen.rig);
    print_map_summary(request, sums, json);
    print_delay_budget(job.chosen.rig);
    std::printf("map       %s.csv\n", stem.c_str());
    std::printf(arguments.picture ? "picture   %s.png\n"
                                  : "picture   .venv/bin/python scripts/map_picture.py %s.csv\n",
                stem.c_str());
    return 0;
}

} // namespace berth
