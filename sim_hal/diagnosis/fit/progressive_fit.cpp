#include "progressive_fit.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace berth
{

namespace
{

constexpr double first_horizon_s = 0.5;
constexpr double growth_max = 0.25; /* of the horizon, from one to the next */
constexpr double growth_min = 0.01;
constexpr int stuck_max = 4;     /* times that nothing helps: another history than any that was tried */
constexpr double suffices = 1.5; /* white sum of squares per row */

/* The beginning of a record, and a model of it that uses the same rows. */
struct horizon {
    record part;
    sample_events events;
    std::unique_ptr<block_model> model;
};

template <typename T>
void cut(std::vector<T> &values, std::size_t rows)
{
    if (values.size() > rows) {
        values.resize(rows);
    }
}

std::unique_ptr<horizon> horizon_of(const block_model &whole, const rig &base, std::size_t rows)
{
    auto made = std::make_unique<horizon>();
    made->part = first_rows(whole.data(), rows);
    made->events = whole.events();
    std::vector<row_use> uses = whole.uses();
    cut(uses, rows);
    made->model = std::make_unique<block_model>(whole.which(), made->part, base, made->events, held_out_parts::none);
    made->model->use(std::move(uses));
    return made;
}

/* Also in the rows that are new: few bad ones are lost among many good ones. */
bool goes_on_well(const fit_result &next, const fit_result &known)
{
    constexpr double chance = 40.0;
    const auto rows_more = static_cast<double>(next.rows - std::min(next.rows, known.rows));
    return next.cost < suffices * static_cast<double>(next.rows) &&
           next.cost - known.cost < suffices * rows_more + chance;
}

/* The size that suits the horizon best, of `sizes` and then between its neighbours, ever closer. */
double best_size(block_model &model, const noise_model &noise, rig at, std::string_view key,
                 const std::vector<double> &sizes)
{
    double best = sizes.front();
    double least = unlimited;
    const auto look = [&](double size) {
        set_number(at, key, size);
        const double cost = cost_of(model, noise, at);
        if (cost < least) {
            least = cost;
            best = size;
        }
    };
    for (const double size : sizes) {
        look(size);
    }
    constexpr int rounds = 6;
    double spacing = 0.05;
    for (int round = 0; round < rounds; round++) {
        const double middle = best;
        for (const double place : {-0.9, -0.7, -0.5, -0.3, 0.3, 0.5, 0.7, 0.9}) {
            look(middle * (1.0 + spacing * place));
        }
        spacing *= 0.3;
    }
    return best;
}

/* Rows until the block's input has first moved by a tenth of its range, and half a second more. */
std::size_t first_movement(const record &data)
{
    constexpr double share = 0.1;
    const std::vector<double> &x = data.command_position_m.empty() ? data.robot_position_m : data.command_position_m;
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    const double far = share * (*most - *least);
    const auto moved =
        std::find_if(x.begin(), x.end(), [&](double value) { return std::abs(value - x.front()) > far; });
    const auto more = static_cast<std::size_t>(first_horizon_s / data.period_s);
    return std::min(x.size(), static_cast<std::size_t>(moved - x.begin()) + more);
}

struct tried_size {
    double size;
    double cost;
};

/* From the smallest start to the largest. */
std::vector<tried_size> evenly_between(const std::vector<rig> &starts, std::string_view key, double spacing)
{
    double least = unlimited;
    double largest = 0.0;
    for (const rig &start : starts) {
        least = std::min(least, value_of(start, key));
        largest = std::max(largest, value_of(start, key));
    }
    std::vector<tried_size> sizes;
    double size = least;
    while (size > 0.0 && size <= largest) {
        sizes.push_back({size, 0.0});
        size *= 1.0 + spacing;
    }
    return sizes;
}

/* The best ones, no two of them nearer than `apart` of their size. */
std::vector<tried_size> best_apart(std::vector<tried_size> tried, std::size_t count, double apart)
{
    std::sort(tried.begin(), tried.end(), [](const tried_size &a, const tried_size &b) { return a.cost < b.cost; });
    std::vector<tried_size> kept;
    for (const tried_size &one : tried) {
        const bool is_near = std::any_of(kept.begin(), kept.end(), [&](const tried_size &other) {
            return std::abs(one.size - other.size) < apart * other.size;
        });
        if (!is_near && kept.size() < count) {
            kept.push_back(one);
        }
    }
    return kept;
}

} // namespace

fit_result fit_progressively(block_model &model, const noise_model &noise, const effect &effect, const rig &base,
                             const std::vector<free_parameter> &parameters, const std::vector<rig> &starts,
                             int replays_max)
{
    const std::string_view key = effect.parameters[0].key;
    std::vector<double> sizes;
    sizes.reserve(starts.size());
    for (const rig &start : starts) {
        sizes.push_back(value_of(start, key));
    }
    const std::size_t all = model.data().size();
    bool has_effect = false;
    fit_result fitted;
    fitted.rig = base;
    fitted.parameters = parameters;
    const auto fit_size = [&](block_model &to, double own) {
        rig at = fitted.rig;
        std::vector<double> among = sizes;
        among.insert(among.end(), own > 0.0 ? 1 : 0, own);
        const double size = best_size(to, noise, at, key, among);
        set_number(at, key, size);
        const auto with_size = joined(parameters, {{find_key(key), 0.5 * size, 2.0 * size}});
        return fit(to, noise, at, with_size, replays_max);
    };
    double known = first_horizon_s / model.data().period_s; /* rows that are explained */
    double growth = growth_max;
    for (int stuck = 0; known * (1.0 + growth) < static_cast<double>(all) && stuck < stuck_max;) {
        const double rows = known * (1.0 + growth);
        const auto part = horizon_of(model, base, static_cast<std::size_t>(rows));
        fit_result next = fit(*part->model, noise, fitted.rig, fitted.parameters, replays_max);
        bool comes_in = false;
        if (!goes_on_well(next, fitted)) {
            fit_result other = fit_size(*part->model, value_of(fitted.rig, key));
            comes_in = other.cost < next.cost;
            next = comes_in ? std::move(other) : std::move(next);
        }
        const bool is_well = goes_on_well(next, fitted);
        if (!is_well && growth >= growth_min) {
            growth *= 0.3;
            continue;
        }
        stuck += is_well ? 0 : 1;
        growth = is_well ? std::min(growth_max, 2.0 * growth) : growth_max;
        known = rows;
        has_effect = has_effect || comes_in;
        fitted = std::move(next);
    }
    if (!has_effect) {
        return fit_size(model, 0.0);
    }
    return fit(model, noise, fitted.rig, fitted.parameters, replays_max);
}

std::optional<rig> size_on_growing_horizon(block_model &model, const noise_model &noise, const effect &effect,
                                           const rig &base, const std::vector<free_parameter> &parameters,
                                           const std::vector<rig> &starts, int replays_max)
{
    const noise_model white{{}, noise.rms, noise.rms, noise.rows_per_fact};
    constexpr double longer = 1.4;
    constexpr std::size_t followed = 8;
    constexpr double first_spacing = 0.04; /* of the size */
    constexpr double clear = 20.0;         /* white sum of squares */
    const std::vector<double> few = {-0.25, 0.25};
    const std::vector<double> many = {-1.0, -0.65, -0.4, -0.2, 0.0, 0.2, 0.4, 0.65, 1.0};
    const std::string_view key = effect.parameters[0].key;
    const auto all = static_cast<double>(model.data().size());
    const auto first = static_cast<double>(first_movement(model.data()));
    rig at = base;
    std::vector<tried_size> kept = evenly_between(starts, key, first_spacing);
    double rows = kept.empty() ? 2.0 * all : first;
    while (rows <= all) {
        const auto part = horizon_of(model, base, static_cast<std::size_t>(rows));
        const double spacing = first_spacing * first / rows;
        std::vector<tried_size> tried;
        for (const tried_size &one : kept) {
            for (const double place : kept.size() > followed ? few : many) {
                const double size = one.size * (1.0 + spacing * place);
                set_number(at, key, size);
                tried.push_back({size, cost_of(*part->model, white, at)});
            }
        }
        const bool is_first = kept.size() > followed;
        kept = best_apart(std::move(tried), followed, 0.1 * spacing);
        if (is_first && kept.front().cost > cost_of(*part->model, white, base) - clear) {
            return {};
        }
        set_number(at, key, kept.front().size);
        at = fit(*part->model, white, at, parameters, replays_max).rig;
        rows = rows < all ? std::min(all, rows * longer) : 2.0 * all;
    }
    return at;
}

} // namespace berth
