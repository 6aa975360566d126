#include "next_experiment.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "calibration.h"
#include "fit/response.h"
#include "formatted.h"
#include "search/acceptance.h"

namespace berth
{

namespace
{

constexpr double excursion_factor =
    6.0; /* farther than so many times the record's own way, models are not trusted */
constexpr std::size_t rivals_max = 3;
constexpr std::size_t refined_max = 3; /* excitations whose gap is found by a fit rather than by projection */
constexpr int refit_replays_max = 60;

/* An explanation, fitted to the record. */
struct hypothesis {
    const berth::effect *effect; /* nullptr: the re-tuned rig, and what was found before */
    fit_result fitted;
};

std::string name_of(const hypothesis &one, const block_diagnosis &found)
{
    const char *const no_more = found.causes.empty() ? "nothing" : "no more than what is named";
    return one.effect == nullptr ? no_more : std::string(one.effect->name);
}

/* `special` is what `general` becomes for some values of its parameters. */
bool contains(const hypothesis &general, const hypothesis &special)
{
    return general.effect != nullptr &&
           (special.effect == nullptr || general.effect->generalises == special.effect->name);
}

/* By which BIC has to differ before one of the two is named. */
double gap_needed(const hypothesis &a, const hypothesis &b)
{
    const bool look_alike = a.effect != nullptr && b.effect != nullptr && a.effect->look_alike == b.effect->name;
    return look_alike ? bic_look_alike : bic_clear;
}

/* An earlier cause and what may stand in its place, or those that were fitted anew beside the force, or the winner
 * of a round and what came near it in the same round. */
std::vector<hypothesis> rivals_of_winner(const block_diagnosis &found)
{
    const ranked *winner = nullptr;
    std::vector<hypothesis> rivals;
    for (const alternative &other : found.alternatives) {
        if (other.rival_of != nullptr) {
            return {{other.rival_of, found.fitted}, {other.effect, other.fitted}};
        }
    }
    for (const alternative &other : found.alternatives) {
        if (!other.fitted.parameters.empty()) {
            rivals.push_back({other.effect, other.fitted});
        }
    }
    if (!rivals.empty()) {
        rivals.insert(rivals.begin(), {found.causes.back().effect, found.fitted});
        return rivals;
    }
    for (const alternative &other : found.alternatives) {
        for (const ranked &best : found.ranking) {
            const bool is_cause = std::any_of(found.causes.begin(), found.causes.end(),
                                              [&](const cause &known) { return known.effect == best.effect; });
            const bool is_other_round = winner != nullptr && winner->round != best.round;
            if (!is_cause || is_other_round) {
                continue;
            }
            const auto near = std::find_if(found.ranking.begin(), found.ranking.end(), [&](const ranked &one) {
                const double distance = best.delta_bic - one.delta_bic;
                return one.effect == other.effect && one.round == best.round &&
                       std::abs(distance - other.delta_bic) < 1e-6 * (1.0 + std::abs(best.delta_bic));
            });
            if (near != found.ranking.end()) {
                if (winner == nullptr) {
                    rivals.push_back({best.effect, best.fitted});
                }
                winner = &best;
                rivals.push_back({near->effect, near->fitted});
                break;
            }
        }
    }
    return rivals;
}

/* What was found so far, and the best of what was not accepted; what hardly lowers the error is none. */
std::vector<hypothesis> rivals_of_rest(const block_diagnosis &found)
{
    std::vector<hypothesis> rivals{{nullptr, found.fitted}};
    const int last = static_cast<int>(found.causes.size()) + 1;
    for (const ranked &one : found.ranking) { /* best first in each round */
        const bool is_cause = std::any_of(found.causes.begin(), found.causes.end(),
                                          [&](const cause &known) { return known.effect == one.effect; });
        if (one.round == last && !is_cause && one.delta_bic > bic_undecided && rivals.size() < rivals_max) {
            rivals.push_back({one.effect, one.fitted});
        }
    }
    return rivals;
}

/* A simulated record with the signals that the real one has. */
std::optional<record> measured_as(const record &shown, const rig &rig, const excitation &excitation)
{
    double least_m = unlimited;
    double largest_m = -unlimited;
    for (const double x : shown.command_position_m) {
        least_m = std::min(least_m, x);
        largest_m = std::max(largest_m, x);
    }
    auto made = simulate_experiment(rig, excitation, excursion_factor * (largest_m - least_m));
    if (made && shown.robot_position_m.empty()) {
        made->robot_position_m.clear();
    }
    if (made && shown.force_N.empty()) {
        made->force_N.clear();
    }
    return made;
}

double bic_gap(double square, std::size_t rows, std::size_t parameters, std::size_t other_parameters)
{
    const double count = static_cast<double>(std::max<std::size_t>(1, rows));
    return count * std::log1p(std::max(0.0, square) / count) +
           (static_cast<double>(other_parameters) - static_cast<double>(parameters)) * std::log(count);
}

/* A pair of rivals in one experiment. */
class duel
{
  public:
    duel(const block_diagnosis &found, bool refits) : block_(found.block), noise_(found.floor), refits_(refits) {}

    /* By how much BIC will prefer the truth, which made `data`, to a rival that is fitted to the data. */
    double gap(const hypothesis &truth, const record &data, const hypothesis &rival) const
    {
        const sample_events none;
        block_model model(block_, data, truth.fitted.rig, none, held_out_parts::two_tenths);
        const Eigen::VectorXd there = white_error(model, noise_, truth.fitted.rig);
        const auto rows = static_cast<std::size_t>(static_cast<double>(there.size()) / noise_.rows_per_fact);
        double square = 0.0;
        if (refits_) {
            square = fit(model, noise_, rival.fitted.rig, rival.fitted.parameters, refit_replays_max).cost -
                     there.squaredNorm();
        } else {
            const Eigen::VectorXd here = white_error(model, noise_, rival.fitted.rig);
            square = tangent_space(model, noise_, rival.fitted, here).less(there - here).squaredNorm();
        }
        return bic_gap(std::isfinite(square) ? square : 0.0, rows, truth.fitted.parameters.size(),
                       rival.fitted.parameters.size());
    }

    /* The gap as a multiple of what is needed, for the truth that is harder to see. What contains the other one can
     * always do as well: then only its own being true shows. */
    double share_of_need(const hypothesis &a, const record &by_a, const hypothesis &b, const record &by_b) const
    {
        double least = unlimited;
        if (!contains(b, a)) {
            least = std::min(least, gap(a, by_a, b));
        }
        if (!contains(a, b)) {
            least = std::min(least, gap(b, by_b, a));
        }
        return least / gap_needed(a, b);
    }

  private:
    berth::block block_;
    const noise_model &noise_;
    bool refits_;
};

struct outcome {
    std::size_t excitation;
    double share = -unlimited; /* of what is needed, for what is hardest to see */
    std::pair<std::size_t, std::size_t> hardest{0, 0};
    double gap = 0.0; /* of BIC */
};

/* Nothing: the run would not stay within its limits under one of the rivals. */
std::optional<outcome> try_out(const block_diagnosis &found, const record &shown,
                               const std::vector<hypothesis> &rivals, const excitation &excitation, bool refits)
{
    std::vector<record> records;
    for (const hypothesis &one : rivals) {
        auto made = measured_as(shown, one.fitted.rig, excitation);
        if (!made) {
            return {};
        }
        records.push_back(std::move(*made));
    }
    const duel duel(found, refits);
    outcome result{0, unlimited, {0, 0}, 0.0};
    for (std::size_t i = 0; i < rivals.size(); i++) {
        for (std::size_t j = i + 1; j < rivals.size(); j++) {
            const double share = duel.share_of_need(rivals[i], records[i], rivals[j], records[j]);
            if (share < result.share) {
                result.share = share;
                result.hardest = {i, j};
                result.gap = std::max(0.0, share) * gap_needed(rivals[i], rivals[j]);
            }
        }
    }
    return result;
}

/* Best first. */
std::vector<outcome> best_of(const std::vector<excitation> &excitations,
                             const std::function<std::optional<outcome>(const excitation &)> &judge)
{
    std::vector<outcome> all;
    for (std::size_t i = 0; i < excitations.size(); i++) {
        if (auto made = judge(excitations[i])) {
            made->excitation = i;
            all.push_back(*made);
        }
    }
    std::stable_sort(all.begin(), all.end(), [](const outcome &a, const outcome &b) { return a.share > b.share; });
    return all;
}

/* Where the library has no hypothesis: what would show of which kind the rest is. */
next_experiment look_closer(const block_diagnosis &found)
{
    constexpr double follows = 0.01; /* of the explainable error */
    constexpr const char *closer[static_cast<std::size_t>(error_class::count)] = {
        "a slow chirp, once small and once large: the frequencies at which the rest grows tell what it is",
        "the same motion at half and at twice its size: what is left then grows less or more than the motion",
        "the same motion about two other middle positions: what is left then changes with the place",
        "rest, for as long as this record: what wanders then does not come from the motion",
        "slowly to and fro over the whole way: what differs between there and back is friction, play or hysteresis"};
    next_experiment made;
    made.rig = found.fitted.rig;
    made.why = "no effect of the library comes near what is left";
    if (std::find(found.doubts.begin(), found.doubts.end(), friction_may_fall) != found.doubts.end()) {
        made.why = "what is left does not tell the two kinds of friction apart";
        made.calibration = "to and fro at several constant speeds: the force less the spring's "
                           "is the friction there";
        return made;
    }
    made.calibration =
        found.left < follows && !found.floor_is_measured
            ? "rest, as --standstill, or the same command once more, as --repeat: what is left may be noise"
            : closer[static_cast<std::size_t>(found.left_class)];
    return made;
}

} // namespace

next_experiment tell_rivals_apart(const block_diagnosis &found, const record &shown, const rig &given)
{
    std::vector<hypothesis> rivals;
    if (found.verdict == verdict::one_of) {
        rivals = rivals_of_winner(found);
    }
    if (rivals.size() < 2) {
        rivals = rivals_of_rest(found); /* also what fits better, but does not predict better */
    }
    if (rivals.size() > rivals_max) {
        rivals.resize(rivals_max);
    }
    if (rivals.size() < 2) {
        return look_closer(found);
    }
    next_experiment made;
    made.rig = rivals[0].fitted.rig;
    for (const hypothesis &one : rivals) {
        made.rivals.push_back(name_of(one, found));
    }
    const std::vector<excitation> excitations = candidate_excitations(given, shown);
    std::vector<outcome> ranking =
        best_of(excitations, [&](const excitation &one) { return try_out(found, shown, rivals, one, false); });
    if (ranking.empty()) {
        made.why = "no simulated excitation stays within the limits of the rig";
        return made;
    }
    outcome best;
    for (std::size_t i = 0; i < std::min(refined_max, ranking.size()); i++) {
        const std::size_t place = ranking[i].excitation;
        if (auto refined = try_out(found, shown, rivals, excitations[place], true)) {
            refined->excitation = place;
            best = refined->share > best.share ? *refined : best;
        }
    }
    const hypothesis &a = rivals[best.hardest.first];
    const hypothesis &b = rivals[best.hardest.second];
    made.predicted_gap = best.gap;
    const std::string pair = name_of(a, found) + " and " + name_of(b, found);
    if (best.share < 1.0) {
        made.calibration = calibration_for(a.effect, b.effect);
        made.why = "whatever the operator does, re-fitted parameters make " + pair +
                   formatted(" alike: at best BIC differs by %.0f, where %.0f would decide", made.predicted_gap,
                             gap_needed(a, b));
        return made;
    }
    made.proposed = excitations[best.excitation];
    made.why = "of " + std::to_string(ranking.size()) + " excitations it keeps " + pair +
               formatted(" farthest apart: BIC should differ by %.0f, where %.0f decides", made.predicted_gap,
                         gap_needed(a, b));
    return made;
}

std::optional<next_experiment> show_more(const block_diagnosis &found, const std::vector<detectable_size> &sizes,
                                         const record &shown, const rig &given)
{
    constexpr double worthwhile = 1.2; /* times smaller sizes */
    std::vector<const detectable_size *> told;
    for (const detectable_size &one : sizes) {
        if (one.value && !one.effect->is_of_single_samples) {
            told.push_back(&one);
        }
    }
    if (told.empty()) {
        return {};
    }
    const auto judge = [&](const excitation &excitation) -> std::optional<outcome> {
        const auto data = measured_as(shown, found.fitted.rig, excitation);
        if (!data) {
            return {};
        }
        const sample_events none;
        block_model model(found.block, *data, found.fitted.rig, none, held_out_parts::two_tenths);
        const Eigen::VectorXd here = white_error(model, found.floor, found.fitted.rig);
        const tangent_space tangents(model, found.floor, found.fitted, here);
        const double rows = static_cast<double>(here.size()) / found.floor.rows_per_fact;
        const double needed = square_to_be_seen(rows, static_cast<std::size_t>(rows), 1);
        std::vector<double> squares;
        for (const detectable_size *const one : told) {
            const double square = tangents.less(white_error(model, found.floor, one->rig) - here).squaredNorm();
            squares.push_back(std::isfinite(square) ? square : 0.0);
        }
        outcome result{0, 0.0, {0, 0}, 0.0};
        const double usual = median_of(squares);
        result.share = std::sqrt(usual / needed);
        result.gap = bic_gap(usual, static_cast<std::size_t>(rows), 1, 0);
        return result;
    };
    const std::vector<excitation> excitations = candidate_excitations(given, shown);
    const std::vector<outcome> ranking = best_of(excitations, judge);
    next_experiment made;
    made.rig = found.fitted.rig;
    made.rivals = {"nothing", "every effect of the block in the size that this record just shows"};
    if (ranking.empty()) {
        made.why = "no simulated excitation stays within the limits of the rig";
        return made;
    }
    const outcome &best = ranking.front();
    if (best.share < worthwhile) {
        made.why = "no other excitation shows much smaller effects than this record";
        return made;
    }
    made.proposed = excitations[best.excitation];
    made.predicted_gap = best.gap;
    made.why =
        "of " + std::to_string(ranking.size()) +
        formatted(" excitations it shows the smallest effects: in the median %.3g times smaller ones than this "
                  "record",
                  best.share);
    return made;
}

} // namespace berth
