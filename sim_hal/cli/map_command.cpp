#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>
#include <unistd.h>

#include "atomic_file.h"
#include "map_request.h"
#include "robot_choice.h"

namespace berth
{

namespace
{

/* Above this many points the user is asked. */
constexpr std::size_t large_map_points = 10000000;
constexpr double row_bytes = 75; /* of a CSV line, about */
constexpr double radius_bytes = 19;

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
    double least = std::numeric_limits<double>::infinity();
    double largest = 0.0;

    void add(double radius, bool is_below_wall)
    {
        possible++;
        below_wall += is_below_wall;
        stable += radius < 1.0;
        stable_below_wall += is_below_wall && radius < 1.0;
        least = std::min(least, radius);
        largest = std::max(largest, radius);
    }
};

/* The map that is asked for and, where a range of dead times is reported, the same at the lower end of it. */
template <typename T>
struct band {
    T map;
    std::optional<T> lower_end;
};

band<map_request> with_lower_end(const map_request &request, const chosen_rig &chosen)
{
    constexpr const char *dead_time = "robot.dead_time_ms"; /* as an axis, it has no range at a point */
    band<map_request> requests{request, {}};
    if (chosen.dead_time_band && request.x.name != dead_time && request.y.name != dead_time) {
        requests.lower_end = request;
        requests.lower_end->rig = chosen.at_lower_end();
    }
    return requests;
}

band<map_result> compute_maps(const band<map_request> &requests, int threads,
                              const std::function<void(int)> &rows_done = {})
{
    band<map_result> maps{compute_map(requests.map, threads, rows_done), {}};
    if (requests.lower_end) {
        maps.lower_end = compute_map(*requests.lower_end, threads, [&](int rows) {
            if (rows_done) {
                rows_done(requests.map.y.count + rows);
            }
        });
    }
    return maps;
}

/* Hands the lines of the CSV file to `write`, row by row; returns what they amount to. */
band<summary> write_csv(const map_request &request, const band<map_result> &maps,
                        const std::function<void(std::string_view)> &write)
{
    band<summary> sums;
    if (maps.lower_end) {
        sums.lower_end.emplace();
    }
    write(request.x.name + "," + request.y.name + ",spectral_radius,growth_per_s,wall" +
          (maps.lower_end ? ",spectral_radius_low" : "") + "\n");
    std::string lines;
    map_point_setter setter(request);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    const double *value = maps.map.spectral_radius.data();
    const double *lower_value = maps.lower_end ? maps.lower_end->spectral_radius.data() : nullptr;
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
                sums.map.add(radius, is_below);
            } else {
                (state == point_state::invalid ? sums.map.invalid : sums.map.not_passive)++;
            }
            append(lines, x, ',');
            append(lines, y, ',');
            append(lines, radius, ',');
            append(lines, growth_per_s, ',');
            append(lines, wall, lower_value != nullptr ? ',' : '\n');
            if (lower_value != nullptr) {
                const double lower_radius = *lower_value++;
                append(lines, lower_radius, '\n');
                if (!std::isnan(lower_radius)) {
                    sums.lower_end->add(lower_radius, wall == 1.0);
                }
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

void ask_if_large(const band<map_request> &requests, int threads, bool yes)
{
    const map_request &request = requests.map;
    if (request.points() <= large_map_points || yes) {
        return;
    }
    /* The map itself with all threads, its file with one. */
    band<map_request> sample{sample_of(request), {}};
    if (requests.lower_end) {
        sample.lower_end = sample_of(*requests.lower_end);
    }
    const auto start = std::chrono::steady_clock::now();
    const band<map_result> maps = compute_maps(sample, 1);
    const auto computed = std::chrono::steady_clock::now();
    write_csv(sample.map, maps, [](std::string_view) {});
    const std::chrono::duration<double> compute = computed - start;
    const std::chrono::duration<double> write = std::chrono::steady_clock::now() - computed;
    const double duration_s = (compute.count() / threads + write.count()) * static_cast<double>(request.points()) /
                              static_cast<double>(sample.map.points());
    const double points = static_cast<double>(request.points());
    const double maps_each = requests.lower_end ? 2.0 : 1.0;
    const double line_bytes = requests.lower_end ? row_bytes + radius_bytes : row_bytes;
    char text[300];
    std::snprintf(
        text, sizeof text,
        "map: %.3g points take about %.0f s on %d thread%s, %.1f GB of memory and %.1f GB of disk; say --yes "
        "to go on",
        points, std::ceil(duration_s), threads, threads == 1 ? "" : "s",
        maps_each * points * static_cast<double>(sizeof(double)) / 1e9, points * line_bytes / 1e9);
    throw input_error(text);
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

/* What a map amounts to: shares and extremes, and the rig itself. */
nlohmann::json sums_as_json(const map_request &request, const summary &sums)
{
    const spectrum own = loop_spectrum(request.rig);
    const auto share = [](std::size_t part, std::size_t of) {
        return of > 0 ? nlohmann::json(static_cast<double>(part) / static_cast<double>(of)) : nlohmann::json();
    };
    const bool has_points = sums.possible > 0;
    return {{"stable_share", share(sums.stable, sums.possible)},
            {"stable_share_below_wall", share(sums.stable_below_wall, sums.below_wall)},
            {"spectral_radius_min", has_points ? nlohmann::json(sums.least) : nlohmann::json()},
            {"spectral_radius_max", has_points ? nlohmann::json(sums.largest) : nlohmann::json()},
            {"own",
             {{"x", value_of(request.rig, request.x.name)},
              {"y", value_of(request.rig, request.y.name)},
              {"spectral_radius", own.spectral_radius},
              {"growth_per_s", own.growth_per_s},
              {"stable", own.is_stable}}}};
}

nlohmann::json as_json(const band<map_request> &requests, const band<summary> &sums, const chosen_rig &chosen)
{
    const map_request &request = requests.map;
    const manipulator_config &arm = request.rig.firmware.manipulator;
    const double arm_Hz = std::sqrt(arm.stiffness_N_per_m / arm.mass_kg) / 6.28318530717958647692;
    nlohmann::json json = sums_as_json(request, sums.map);
    json.update({{"rig", request.rig.name},
                 {"robot", robot_as_json(chosen)},
                 {"lower_end", nullptr},
                 {"vary", request.kind == map_kind::mass         ? nlohmann::json("mass")
                          : request.kind == map_kind::elasticity ? nlohmann::json("elasticity")
                                                                 : nlohmann::json()},
                 {"axes", {{"x", axis_json(request.x)}, {"y", axis_json(request.y)}}},
                 {"points", request.points()},
                 {"points_possible", sums.map.possible},
                 {"points_not_passive", sums.map.not_passive},
                 {"points_invalid", sums.map.invalid},
                 {"wall_Hz", wall_Hz},
                 {"manipulator_Hz", arm_Hz}});
    if (requests.lower_end) {
        json["lower_end"] = sums_as_json(*requests.lower_end, *sums.lower_end);
        json["lower_end"]["dead_time_ms"] = requests.lower_end->rig.robot.dead_time_ms;
    }
    return json;
}

/* With a range of dead times: from its upper to its lower end. */
void print_band(const nlohmann::json &json)
{
    if (!json["robot"].is_null()) {
        std::printf("  robot %s\n", robot_sentence(json["robot"]).c_str());
    }
    const nlohmann::json &lower = json["lower_end"];
    if (!lower.is_null() && !lower["stable_share"].is_null()) {
        std::printf("  at the lower end, %g ms, %.1f %% of the possible stable", lower["dead_time_ms"].get<double>(),
                    100.0 * lower["stable_share"].get<double>());
        if (!lower["stable_share_below_wall"].is_null()) {
            std::printf(", %.1f %% of those below the wall", 100.0 * lower["stable_share_below_wall"].get<double>());
        }
        std::printf("; the rig itself: |z| %.9f\n", lower["own"]["spectral_radius"].get<double>());
    }
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
    print_band(json);
    std::printf("  %.3f s for the map\n", json["compute_s"].get<double>());
}

} // namespace

int map_command(const map_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    const band<map_request> requests = with_lower_end(make_map_request(arguments, chosen.rig), chosen);
    const map_request &request = requests.map;
    const int threads = arguments.threads > 0 ? arguments.threads
                                              : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    ask_if_large(requests, threads, arguments.yes);

    std::error_code error;
    std::filesystem::create_directories(arguments.out_folder, error);
    if (error) {
        throw input_error(arguments.out_folder + ": cannot be made: " + error.message());
    }
    progress_bar bar(request.y.count * (requests.lower_end ? 2 : 1));
    const auto start = std::chrono::steady_clock::now();
    const double cpu_start_s = cpu_s();
    const band<map_result> maps = compute_maps(requests, threads, [&](int rows) { bar.show(rows); });
    const double cpu_taken_s = cpu_s() - cpu_start_s;
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    bar.clear();

    const std::string what = request.kind == map_kind::keys ? request.x.name + "-" + request.y.name : arguments.vary;
    const std::string stem =
        arguments.out_folder + "/" + request.rig.name + (chosen.robot ? "-" + chosen.robot->name : "") + "-" + what;
    atomic_file csv(stem + ".csv");
    const band<summary> sums = write_csv(request, maps, [&](std::string_view text) { csv.write(text); });
    csv.finish();
    nlohmann::json json = as_json(requests, sums, chosen);
    atomic_file beside(stem + ".json");
    beside.write(json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
    beside.finish();
    json["csv"] = stem + ".csv";
    json["compute_s"] = taken.count();
    json["compute_cpu_s"] = cpu_taken_s;
    json["threads"] = threads;
    json["searches"] = maps.map.searches + (maps.lower_end ? maps.lower_end->searches : 0);
    if (arguments.json) {
        print_json(json);
        return 0;
    }
    print_for_a_person(request, sums.map, json);
    std::printf("map       %s.csv\npicture   .venv/bin/python scripts/map_picture.py %s.csv\n", stem.c_str(),
                stem.c_str());
    return 0;
}

} // namespace berth
