#include "right_history.h"

#include <algorithm>
#include <cmath>

#include "../search/search.h"

namespace berth
{

namespace
{

constexpr double stretch_s = 0.1;
constexpr double usual = 1.5;      /* rms of a stretch that is right, by that of the noise */
constexpr double part_least = 0.2; /* of the rows */
constexpr int looks_max = 24;
constexpr double clearly_less = 0.995;
/* Of the size, where it leads no further from where it is. */
constexpr double nudges[] = {0.0, 0.003, -0.003, 0.01, -0.01, 0.03, -0.03};

/* Rows of the fit in stretches whose error is like the noise; where fewer than half are, those below the median. The
 * stretch before one that is wrong, and the two after it, are left out too. */
std::vector<row_use> right_rows(const block_model &model, const std::vector<double> &error, double noise_rms)
{
    const auto length = std::max<std::size_t>(4, static_cast<std::size_t>(stretch_s / model.data().period_s));
    std::vector<row_use> uses = model.uses();
    std::vector<double> sizes;
    for (std::size_t begin = 0; begin < uses.size(); begin += length) {
        double square = 0.0;
        double count = 0.0;
        for (std::size_t n = begin; n < std::min(uses.size(), begin + length); n++) {
            if (uses[n] != row_use::none) {
                square += error[n] * error[n];
                count += 1.0;
            }
        }
        sizes.push_back(count > 0.0 ? std::sqrt(square / count) : 0.0);
    }
    const double limit = std::max(usual * noise_rms, median_of(sizes));
    for (std::size_t i = 0; i < sizes.size(); i++) {
        if (sizes[i] > limit) {
            const std::size_t begin = i == 0 ? 0 : (i - 1) * length;
            const std::size_t end = std::min(uses.size(), (i + 3) * length);
            std::fill(uses.begin() + static_cast<std::ptrdiff_t>(begin),
                      uses.begin() + static_cast<std::ptrdiff_t>(end), row_use::none);
        }
    }
    return uses;
}

/* Sum of squares in which no row counts for more than what is no noise any more. */
double truncated_cost(block_model &model, double noise_rms, const rig &rig)
{
    constexpr double most = 25.0;
    std::vector<double> error;
    model.error(rig, error);
    double sum = 0.0;
    for (std::size_t n = 0; n < error.size(); n++) {
        if (model.uses()[n] == row_use::fit) {
            sum += std::min(most, std::pow(error[n] / noise_rms, 2));
        }
    }
    return sum;
}

/* The best size near that of `at`, from far to near. */
double search_size(block_model &model, double noise_rms, rig &at, std::string_view key)
{
    double least = truncated_cost(model, noise_rms, at);
    constexpr int rounds = 10; /* down to a millionth of the size */
    double spread = 0.02;
    for (int round = 0; round < rounds; round++) {
        const double middle = value_of(at, key);
        double best = middle;
        for (const double place : {-1.0, -0.7, -0.4, 0.4, 0.7, 1.0}) {
            set_number(at, key, middle * (1.0 + spread * place));
            const double cost = truncated_cost(model, noise_rms, at);
            if (cost < least) {
                least = cost;
                best = value_of(at, key);
            }
        }
        set_number(at, key, best);
        spread *= 0.35;
    }
    return least;
}

} // namespace

void fit_where_right(block_model &model, const noise_model &noise, std::string_view size_key, fit_result &known,
                     int replays_max)
{
    const noise_model white{{}, noise.rms, noise.rms, noise.rows_per_fact};
    const auto beside_size = [&] {
        std::vector<free_parameter> all = known.parameters;
        all.erase(std::remove_if(all.begin(), all.end(),
                                 [&](const free_parameter &one) { return one.key->path == size_key; }),
                  all.end());
        return all;
    }();
    const std::vector<row_use> uses = model.uses();
    const auto in_fit = [](const std::vector<row_use> &rows) {
        return static_cast<double>(std::count(rows.begin(), rows.end(), row_use::fit));
    };
    rig at = known.rig;
    double least = truncated_cost(model, noise.rms, at);
    /* Looks from `start`; whether something better was found, which is `at` then. */
    const auto look_from = [&](const rig &start) {
        std::vector<double> error;
        model.error(start, error);
        const std::vector<row_use> right = right_rows(model, error, noise.rms);
        if (in_fit(right) < part_least * in_fit(uses)) {
            return false;
        }
        model.use(right);
        rig tried = fit(model, white, start, beside_size, replays_max / 2).rig;
        model.use(uses);
        const double cost = search_size(model, noise.rms, tried, size_key);
        const bool is_better = cost < clearly_less * least;
        at = is_better ? tried : at;
        least = is_better ? cost : least;
        return is_better;
    };
    std::size_t away = 0;
    for (int look = 0; look < looks_max && away < std::size(nudges); look++) {
        rig start = at;
        set_number(start, size_key, value_of(at, size_key) * (1.0 + nudges[away]));
        away = look_from(start) ? 0 : away + 1;
    }
    const double cost = cost_of(model, noise, at);
    if (cost < known.cost) {
        known.rig = at;
        known.cost = cost;
    }
    for (std::size_t i = 0; i < known.parameters.size() && i < known.ci95.size(); i++) {
        if (known.parameters[i].key->path == size_key) {
            known.ci95[i] = std::max(known.ci95[i], width_of_size(model, noise, known, size_key));
        }
    }
}

} // namespace berth
