#include "detectable.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <utility>

#include "../solver/decompositions.h"
#include "fit/response.h"
#include "samples/events.h"
#include "samples/lost_commands.h"
#include "samples/spikes.h"
#include "search/acceptance.h"

namespace berth
{

namespace
{

constexpr double sure_sd = 1.645; /* 19 of 20 lie above the mean less this */
constexpr double sure_count =
    9.2; /* 19 of 20 draws from a Poisson distribution of this mean are events_min or more */
constexpr double near_enough = 0.1; /* of the logarithm of a sum of squares: 5 % of a size */
constexpr std::size_t scan_max = 6;

struct point {
    double place; /* logarithm of the size */
    double height;
};

/* The place beyond the end of a rising curve where it should pass 0, by the slope of its two points there. */
double beyond(const point &end, const point &inner)
{
    constexpr double step_max = 2.3;
    const double slope = (end.height - inner.height) / (end.place - inner.place);
    const double step = std::isfinite(slope) && slope != 0.0 ? -1.3 * end.height / slope : 0.0;
    const double outwards = end.place > inner.place ? 1.0 : -1.0;
    const double least = 0.25 * std::abs(end.place - inner.place);
    return end.place + outwards * std::min(step_max, std::max(least, std::abs(step)));
}

/* Where `height`, which grows or falls with the logarithm of the size, passes 0. From one place only, it grows as a
 * square does. */
std::optional<double> crossing(const std::function<double(double)> &height, const std::vector<double> &places)
{
    std::vector<point> points;
    points.reserve(places.size());
    for (const double place : places) {
        points.push_back({place, height(place)});
    }
    if (points.size() == 1) {
        const double place = points[0].place - 0.5 * points[0].height;
        points.push_back({place, height(place)});
    }
    std::sort(points.begin(), points.end(), [](const point &a, const point &b) { return a.place < b.place; });
    if (points.back().height < points.front().height) {
        std::reverse(points.begin(), points.end()); /* the side of no effect comes first */
    }
    constexpr int extensions_max = 5;
    for (int i = 0; i < extensions_max && points.front().height > 0.0; i++) {
        const double place = beyond(points[0], points[1]);
        points.insert(points.begin(), {place, height(place)});
    }
    for (int i = 0; i < extensions_max && points.back().height < 0.0; i++) {
        const double place = beyond(points.back(), points[points.size() - 2]);
        points.push_back({place, height(place)});
    }
    const auto above =
        std::find_if(points.begin(), points.end(), [](const point &known) { return known.height >= 0.0; });
    if (above == points.end() || above == points.begin()) {
        return {};
    }
    point high = *above;
    point low = *(above - 1);
    for (int i = 0; i < 10 && high.height > near_enough && std::abs(high.place - low.place) > 0.01; i++) {
        /* Straight between the two, yet never so near to an end that the other one stays. */
        const double share = std::min(0.8, std::max(0.2, -low.height / (high.height - low.height)));
        const double place = low.place + share * (high.place - low.place);
        const point middle{place, height(place)};
        (middle.height >= 0.0 ? high : low) = middle;
    }
    return high.place;
}

/* White errors less what the parameters make up for, as far as their bounds and what was known of them before let
 * them: each prior is a row of its own. */
class what_shows
{
  public:
    what_shows(block_model &model, const noise_model &noise, const fit_result &base, const Eigen::VectorXd &here)
        : slopes_(with_priors(base, slopes_at(model, noise, base, here))), least_(slopes_.cols()),
          most_(slopes_.cols())
    {
        for (Eigen::Index i = 0; i < slopes_.cols(); i++) {
            const free_parameter &known = base.parameters[static_cast<std::size_t>(i)];
            const double value = value_of(base.rig, known.key->path);
            const double size = slopes_.col(i).norm();
            const double unit = size > 0.0 ? size : 1.0;
            slopes_.col(i) /= unit;
            least_(i) = std::min(0.0, known.low - value) * unit;
            most_(i) = std::max(0.0, known.high - value) * unit;
        }
        products_ = slopes_.transpose() * slopes_;
    }

    /* Those that would leave their bounds are held there, the one that would go farthest first. */
    Eigen::VectorXd of(const Eigen::VectorXd &change) const
    {
        Eigen::VectorXd all = Eigen::VectorXd::Zero(slopes_.rows());
        all.head(change.size()) = change;
        const Eigen::VectorXd along = slopes_.transpose() * all;
        Eigen::VectorXd moved = Eigen::VectorXd::Zero(along.size());
        std::vector<Eigen::Index> free(static_cast<std::size_t>(along.size()));
        std::iota(free.begin(), free.end(), 0);
        while (!free.empty()) {
            const Eigen::VectorXd asked = -(along + products_ * held(moved, free));
            const Eigen::VectorXd best = least_norm_solution(products_(free, free), asked(free));
            std::size_t worst = 0;
            double farthest = 0.0;
            for (std::size_t i = 0; i < free.size(); i++) {
                const double value = best(static_cast<Eigen::Index>(i));
                moved(free[i]) = std::min(most_(free[i]), std::max(least_(free[i]), value));
                if (const double beyond = std::abs(value - moved(free[i])); beyond > farthest) {
                    farthest = beyond;
                    worst = i;
                }
            }
            if (!(farthest > 0.0)) {
                break;
            }
            free.erase(free.begin() + static_cast<std::ptrdiff_t>(worst));
        }
        return all + slopes_ * moved;
    }

  private:
    static Eigen::MatrixXd with_priors(const fit_result &base, known_slopes slopes)
    {
        const Eigen::Index rows = slopes.white.rows();
        const Eigen::Index count = slopes.white.cols();
        slopes.white.conservativeResize(rows + count, Eigen::NoChange);
        slopes.white.bottomRows(count).setZero();
        for (Eigen::Index row = 0; row < count; row++) {
            const free_parameter &known = base.parameters[static_cast<std::size_t>(row)];
            for (Eigen::Index column = 0; column < count && known.expected_sd < unlimited; column++) {
                slopes.white(rows + row, column) =
                    strain_slope(known, base.parameters[static_cast<std::size_t>(column)].key);
            }
        }
        return std::move(slopes.white);
    }

    static Eigen::VectorXd held(Eigen::VectorXd moved, const std::vector<Eigen::Index> &free)
    {
        for (const Eigen::Index i : free) {
            moved(i) = 0.0;
        }
        return moved;
    }

    Eigen::MatrixXd slopes_; /* columns of size 1 */
    Eigen::VectorXd least_;  /* how far each may go, in units of its slope */
    Eigen::VectorXd most_;
    Eigen::MatrixXd products_; /* of the slopes with each other */
};

class size_search
{
  public:
    size_search(block_model &model, const noise_model &noise, const fit_result &base, const rig &given)
        : model_(model), noise_(noise), base_(base), given_(given), here_(white_error(model, noise, base.rig)),
          shows_(model, noise, base, here_)
    {
        std::vector<double> error;
        model.error(base.rig, error);
        scales_ = scales_of(model, base.rig, error);
    }

    void add_sizes(const effect &effect, std::vector<detectable_size> &found)
    {
        bool is_re_tuned = false;
        for (const effect_parameter &parameter : effect.parameters) {
            const auto known =
                std::find_if(base_.parameters.begin(), base_.parameters.end(),
                             [&](const free_parameter &free) { return free.key->path == parameter.key; });
            if (known != base_.parameters.end() && effect.switch_on == nullptr) {
                is_re_tuned = true;
                found.push_back(beyond_tolerance(effect, *known));
            }
        }
        if (!is_re_tuned) {
            found.push_back(from_starts(effect));
        }
    }

  private:
    /* How far the sum of squares of a response is above what it has to be, as a logarithm. */
    double height(const Eigen::VectorXd &response, std::size_t parameters) const
    {
        const double square = response.squaredNorm();
        constexpr double nothing = 1e-30;
        return std::log(std::max(nothing, std::isfinite(square) ? square : nothing) /
                        square_to_be_seen(base_.cost, base_.rows, parameters));
    }

    detectable_size no_size(const effect &effect, std::string_view key) const
    {
        return {&effect, key, {}, value_of(given_, key), {}, base_.rig};
    }

    /* The base makes up for what lies within its tolerance, and with its other parameters for some of the rest. */
    detectable_size beyond_tolerance(const effect &effect, const free_parameter &parameter)
    {
        const std::string_view key = parameter.key->path;
        fit_result others = base_;
        others.parameters.erase(std::find_if(others.parameters.begin(), others.parameters.end(),
                                             [&](const free_parameter &free) { return free.key == parameter.key; }));
        set_number(others.rig, key, parameter.high);
        const Eigen::VectorXd at_bound = white_error(model_, noise_, others.rig);
        const what_shows shows(model_, noise_, others, at_bound);
        rig moved = others.rig;
        const auto rises = [&](double place) {
            set_number(moved, key, parameter.high + std::exp(place));
            return height(shows.of(white_error(model_, noise_, moved) - at_bound), 0);
        };
        detectable_size made = no_size(effect, key);
        if (const auto place = crossing(rises, {std::log(0.01 * parameter.high)})) {
            made.value = parameter.high + std::exp(*place);
            set_number(made.rig, key, *made.value);
        }
        return made;
    }

    /* Among starts that differ in more than the size the effect shows best with one of them. */
    detectable_size from_starts(const effect &effect)
    {
        detectable_size best = no_size(effect, effect.parameters[0].key);
        std::vector<effect_values> starts = effect.starts(base_.rig, scales_);
        const double origin = std::isfinite(value_of(base_.rig, best.key)) ? value_of(base_.rig, best.key) : 0.0;
        double best_response = -1.0; /* a limit may not act at the first size */
        for (std::size_t i = 0; i < starts.size(); i++) {
            const bool is_known =
                std::any_of(starts.begin(), starts.begin() + static_cast<std::ptrdiff_t>(i),
                            [&](const effect_values &other) { return is_of_one_kind(starts[i], other); });
            if (is_known || starts[i][0] == origin) {
                continue;
            }
            /* One replay says with which of the others a size shows more. */
            const Eigen::VectorXd there = white_error(model_, noise_, with_values(base_.rig, effect, starts[i]));
            const double response = shows_.of(there - here_).norm();
            if (response > best_response && std::isfinite(response)) {
                best_response = response;
                find_size(effect, starts, starts[i], origin, best);
            }
        }
        return best;
    }

    /* The same but for the size. */
    static bool is_of_one_kind(const effect_values &a, const effect_values &b)
    {
        return std::equal(a.begin() + 1, a.end(), b.begin() + 1, b.end());
    }

    void find_size(const effect &effect, const std::vector<effect_values> &starts, const effect_values &kind,
                   double origin, detectable_size &made)
    {
        const double side = kind[0] < origin ? -1.0 : 1.0;
        std::vector<double> places;
        for (const effect_values &values : starts) {
            if (is_of_one_kind(values, kind) && side * (values[0] - origin) > 0.0) {
                places.push_back(std::log(side * (values[0] - origin)));
            }
        }
        std::sort(places.begin(), places.end());
        if (effect.is_proportional) {
            places.resize(1);
        } else if (places.size() > scan_max) {
            std::vector<double> fewer;
            for (std::size_t i = 0; i < scan_max; i++) {
                fewer.push_back(places[i * (places.size() - 1) / (scan_max - 1)]);
            }
            places = std::move(fewer);
        }
        effect_values values = kind;
        const auto set_size = [&](double place) {
            const effect_parameter &parameter = effect.parameters[0];
            values[0] = std::min(parameter.high, std::max(parameter.low, origin + side * std::exp(place)));
            return with_values(base_.rig, effect, values);
        };
        const std::size_t own = effect_parameters(effect, set_size(places[0])).size();
        /* What the switch does by itself is no matter of the size. */
        effect_values none = kind;
        none[0] = origin;
        const Eigen::VectorXd without =
            effect.switch_on == nullptr ? here_ : white_error(model_, noise_, with_values(base_.rig, effect, none));
        const auto rises = [&](double place) {
            return height(shows_.of(white_error(model_, noise_, set_size(place)) - without), own);
        };
        if (const auto place = crossing(rises, places)) {
            made.rig = set_size(*place);
            made.value = values[0];
            made.others.clear();
            for (std::size_t i = 1; i < values.size(); i++) {
                made.others.push_back({effect.parameters[i].key, values[i]});
            }
        }
    }

    block_model &model_;
    const noise_model &noise_;
    const fit_result &base_;
    const rig &given_;
    Eigen::VectorXd here_;
    what_shows shows_;
    record_scales scales_;
};

/* What is counted in single samples: often enough to be told from chance, or larger than the noise. */
std::optional<detectable_size> single_sample_size(const effect &effect, const block_model &model,
                                                  const noise_model &noise, const rig &base, const rig &given)
{
    const record &data = model.data();
    const bool is_robot = model.which() == block::robot;
    const bool is_force = model.which() == block::force;
    const double often = sure_count / static_cast<double>(data.size());
    detectable_size made{&effect, effect.parameters[0].key, often, value_of(given, effect.parameters[0].key), {},
                         base};
    const double spread = noise.rms * std::sqrt(1.5); /* of a sample about the mean of its neighbours */
    if (effect.name == "sensor.quantisation" && is_force) {
        made.value = noise.rms * std::sqrt(12.0 * rounding_share / (1.0 - rounding_share));
    } else if (effect.name == "sensor.spikes" && is_force) {
        made.others = {{effect.parameters[1].key, (spike_far_sd + sure_sd) * spread}};
        set_number(made.rig, made.others[0].key, made.others[0].value);
    } else if (effect.name == "robot.lost_commands" && is_robot) {
        std::size_t clear = 0;
        for (std::size_t n = 1; n < data.size(); n++) {
            const double way_m = data.command_position_m[n] - data.command_position_m[n - 1];
            clear += std::abs(way_m) > loss_clear_sd * noise.rms;
        }
        made.value = sure_count / static_cast<double>(std::max<std::size_t>(1, clear));
        if (*made.value > 0.25) {
            made.value.reset();
        }
    } else if (!(effect.name == "sensor.dropouts" && is_force) &&
               !(effect.name == "loop.lost_samples" && is_force && !data.robot_position_m.empty())) {
        return {};
    }
    if (made.value) {
        set_number(made.rig, made.key, *made.value);
    }
    return made;
}

} // namespace

double square_to_be_seen(double cost, std::size_t rows, std::size_t parameters)
{
    const double count = static_cast<double>(std::max<std::size_t>(rows, 1));
    const double by_bic = cost * std::expm1((bic_clear + static_cast<double>(parameters) * std::log(count)) / count);
    const double by_share = share_worthwhile / (1.0 - share_worthwhile) * std::max(0.0, cost - count);
    /* What noise adds to a sum of squares S has a standard deviation of 2 sqrt(S). */
    const double root = sure_sd + std::sqrt(sure_sd * sure_sd + std::max(by_bic, by_share));
    return root * root;
}

std::vector<detectable_size> find_detectable(block_model &model, const noise_model &noise, const fit_result &base,
                                             const rig &given, const search_options &options)
{
    size_search search(model, noise, base, given);
    std::vector<detectable_size> found;
    for (const effect &effect : effect_library()) {
        const bool is_left_out =
            std::find(options.without.begin(), options.without.end(), effect.name) != options.without.end();
        if (effect.is_of_single_samples && !is_left_out) {
            if (auto made = single_sample_size(effect, model, noise, base.rig, given)) {
                found.push_back(std::move(*made));
            }
        } else if (is_tried(effect, model, given, {}, options)) {
            search.add_sizes(effect, found);
        }
    }
    return found;
}

} // namespace berth
