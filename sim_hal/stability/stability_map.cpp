#include "stability_map.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "../../hal/rig/axes.h"
#include "../../hal/rig/hardware_model.h"
#include "arm_loop.h"
#include "compensation_states.h"
#include "equivalent_loop.h"
#include "shared_rows.h"
#include "tool_loops.h"

namespace berth
{

namespace
{

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

void set_number(rig &rig, const rig_key &key, double value)
{
    if (key.type == key_type::integer) {
        *static_cast<std::int64_t *>(key.member(rig)) = std::llround(value);
    } else if (key.path == "robot.dead_time_ms") {
        move_dead_time(rig, value);
    } else {
        *static_cast<double *>(key.member(rig)) = value;
    }
}

/* Each point anew: a finder that goes on from its neighbour may follow another mode. NaN: like no linear loop. */
double radius_at_amplitude(const rig &rig, double amplitude_m)
{
    const equivalent_loop found = equivalent_finder(amplitude_m).find(rig);
    return std::isfinite(found.growth_per_s)
               ? dominant_root_finder().spectral_radius(make_loop_equation(found.linear))
               : nan;
}

double worse(double a, double b)
{
    return std::isnan(a) || a > b ? a : b;
}

/* What goes along a row from point to point. */
struct row_worker {
    explicit row_worker(const map_request &request)
        : setter(request), has_flight(request.has_flight), reduced_to(request.reduced_to),
          amplitude_m(request.amplitude_m)
    {
    }

    void start_row(const dominant_root_finder &known)
    {
        finder = known;
        flight_finder = {};
    }

    double value(double x, double y)
    {
        if (setter.set(x, y) != point_state::possible) {
            return nan;
        }
        double worst = 0.0;
        setter.for_each_loop([&](const rig &loop) {
            const double radius = radius_of(loop, finder);
            worst = worse(worst, radius);
            if (has_flight && radius < 1.0) {
                worst = worse(worst, growing_radius(in_free_flight(loop)));
            }
        });
        return worst;
    }

    /* 0 where nothing grows. Bodies that nothing holds may drift, which is no growth. */
    double growing_radius(const rig &flight)
    {
        constexpr double drift_rounding = 1e-6;
        const double radius = radius_of(flight, flight_finder);
        return radius > 1.0 + (drifts_freely(flight) ? drift_rounding : 0.0) ? radius : 0.0;
    }

    double radius_of(const rig &loop, dominant_root_finder &roots)
    {
        if (reduced_to) {
            return roots.spectral_radius(maker.make(with_reduced(loop, *reduced_to)));
        }
        if (compensation_is_on(&loop.firmware) || loop.firmware.arm.kind != ARM_NONE) {
            return spectral_radius_of(loop);
        }
        if (amplitude_m > 0.0) {
            return radius_at_amplitude(loop, amplitude_m);
        }
        return roots.spectral_radius(maker.make(loop));
    }

    map_point_setter setter;
    loop_equation_maker maker;
    dominant_root_finder finder;
    dominant_root_finder flight_finder;
    bool has_flight;
    std::optional<arm_mode> reduced_to;
    double amplitude_m;
};

/* A row starts with the modes that its first possible point has, as the row before knows them. Going up that column
 * first makes rows independent of each other: of their order and of who computes them. */
std::vector<dominant_root_finder> first_finders(const map_request &request, long &searches)
{
    row_worker worker(request);
    std::vector<dominant_root_finder> finders;
    finders.reserve(static_cast<std::size_t>(request.y.count));
    for (int row = 0; row < request.y.count; row++) {
        for (int i = 0; i < request.x.count; i++) {
            if (!std::isnan(worker.value(request.x.value(i), request.y.value(row)))) {
                break;
            }
        }
        finders.push_back(worker.finder);
        finders.back().restart();
    }
    searches = worker.finder.searches();
    return finders;
}

} // namespace

map_point_setter::map_point_setter(const map_request &request)
    : kind_(request.kind), told_(request.told), rig_(request.rig), model_of_the_rig_(request.rig.firmware.hardware),
      errors_(errors_of(request)), x_key_(find_key(request.x.name)), y_key_(find_key(request.y.name))
{
}

/* (K + k) = (w/w_M)^2 K/M (M + m),  D + d = 2 zeta sqrt((K + k)(M + m)) */
point_state map_point_setter::set_coupled(double frequency_ratio, double damping_ratio)
{
    const manipulator_config &arm = rig_.firmware.manipulator;
    object_rig &object = rig_.object;
    const double w2 = frequency_ratio * frequency_ratio * arm.stiffness_N_per_m / arm.mass_kg;
    if (kind_ == map_kind::elasticity) {
        object.stiffness_N_per_m = w2 * (arm.mass_kg + object.mass_kg) - arm.stiffness_N_per_m;
    } else {
        object.mass_kg = (arm.stiffness_N_per_m + object.stiffness_N_per_m) / w2 - arm.mass_kg;
    }
    const double w = frequency_ratio * std::sqrt(arm.stiffness_N_per_m / arm.mass_kg);
    object.damping_N_s_per_m = 2.0 * damping_ratio * w * (arm.mass_kg + object.mass_kg) - arm.damping_N_s_per_m;
    const bool is_passive = object.stiffness_N_per_m >= 0.0 && object.damping_N_s_per_m >= 0.0 &&
                            object.mass_kg > 0.0 && std::isfinite(object.mass_kg);
    if (is_passive && compensation_is_on(&rig_.firmware)) {
        rig_.firmware.hardware = hardware_model_of(rig_); /* the loop knows the rig of this point */
    }
    return is_passive ? point_state::possible : point_state::not_passive;
}

/* Of what the rig file says nothing: 30, 50 and 20 %. */
std::vector<map_point_setter::model_error> map_point_setter::errors_of(const map_request &request)
{
    std::vector<model_error> errors{{}};
    if (request.told != told_model::with_tolerances) {
        return errors;
    }
    const auto share = [&](std::string_view key, double usual) {
        return request.rig.tolerance_of(key).value_or(usual);
    };
    for (const double sign : {-1.0, 1.0}) {
        errors.push_back({1.0 + sign * share("robot.dead_time_ms", 0.3), 1.0, 1.0});
        errors.push_back({1.0, 1.0 + sign * share("object.stiffness_N_per_m", 0.5), 1.0});
        errors.push_back({1.0, 1.0, 1.0 + sign * share("object.mass_kg", 0.2)});
    }
    return errors;
}

point_state map_point_setter::set(double x, double y)
{
    point_state state = set_point(x, y);
    is_scheduled_ = state == point_state::possible && has_schedule(rig_);
    if (is_scheduled_) {
        instants_s_ = instants_of_schedule(rig_);
        const bool has_no_loop = std::any_of(instants_s_.begin(), instants_s_.end(), [&](double at_s) {
            return !reason_against(rig_, rig_at(rig_, at_s)).empty();
        });
        state = has_no_loop ? point_state::invalid : state;
    }
    if (told_ == told_model::of_the_rig) {
        rig_.firmware.hardware = model_of_the_rig_;
    }
    return state;
}

point_state map_point_setter::set_point(double x, double y)
{
    if (kind_ != map_kind::keys) {
        return set_coupled(x, y);
    }
    set_number(rig_, *x_key_, x);
    set_number(rig_, *y_key_, y);
    return complete_and_check(rig_) ? point_state::invalid : point_state::possible;
}

map_result compute_map(const map_request &request, int threads, const std::function<void(int)> &rows_done)
{
    map_result result;
    result.spectral_radius.resize(request.points());
    const std::vector<dominant_root_finder> finders = first_finders(request, result.searches);
    std::atomic<long> searches{0};
    share_rows(request.y.count, threads, rows_done, [&] {
        return [&, worker = row_worker(request)](int row) mutable {
            worker.start_row(finders[static_cast<std::size_t>(row)]);
            const double y = request.y.value(row);
            double *const values =
                &result.spectral_radius[static_cast<std::size_t>(row) * static_cast<std::size_t>(request.x.count)];
            for (int i = 0; i < request.x.count; i++) {
                values[i] = worker.value(request.x.value(i), y);
            }
            searches += worker.finder.searches() - finders[static_cast<std::size_t>(row)].searches();
        };
    });
    result.searches += searches;
    return result;
}

map_request sample_of(const map_request &request)
{
    constexpr int rows = 8;
    constexpr int columns = 500;
    map_request sample = request;
    sample.x.count = std::min(request.x.count, columns);
    const int first = (request.x.count - sample.x.count) / 2;
    sample.x.from = request.x.value(first);
    sample.x.to = request.x.value(first + sample.x.count - 1);
    if (request.y.count > rows) {
        sample.y.count = rows;
        sample.y.from = request.y.value(request.y.count / rows);
        sample.y.to = request.y.value(request.y.count - 1 - request.y.count / rows);
    }
    return sample;
}

} // namespace berth
