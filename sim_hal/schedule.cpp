#include "schedule.h"

#include <algorithm>
#include <cmath>

#include "verdict_words.h"

namespace berth
{

namespace
{

constexpr double exact_share =
    0.01; /* of the run: to this an instant is found at which a drift changes the verdict */

scheduled_loop loop_at(const rig &original, double at_s, const growth_predictor &predict)
{
    scheduled_loop made{at_s, rig_at(original, at_s), {}};
    const std::string why_not = reason_against(original, made.rig);
    made.prediction = why_not.empty() ? predict(made.rig) : growth_prediction{{}, why_not};
    return made;
}

/* Higher is worse. */
int rank_of(const std::optional<bool> &stable)
{
    return stable == std::optional<bool>(false) ? 2 : !stable ? 1 : 0;
}

int rank_of(const growth_prediction &prediction)
{
    return rank_of(is_stable(prediction));
}

bool is_better(const scheduled_loop &a, const scheduled_loop &b)
{
    const int rank_a = rank_of(a.prediction);
    const int rank_b = rank_of(b.prediction);
    return rank_a != rank_b ? rank_a < rank_b
                            : a.prediction.growth_per_s.value_or(0.0) < b.prediction.growth_per_s.value_or(0.0);
}

/* Between two loops of a drift that differ in what they are, the first one that is like the second. */
scheduled_loop first_of_a_kind(const rig &rig, const scheduled_loop &before, const scheduled_loop &after,
                               const growth_predictor &predict)
{
    double inside_s = before.from_s;
    scheduled_loop found = after;
    while (found.from_s - inside_s > exact_share * rig.run.duration_s) {
        const scheduled_loop middle = loop_at(rig, 0.5 * (inside_s + found.from_s), predict);
        if (rank_of(middle.prediction) == rank_of(after.prediction)) {
            found = middle;
        } else {
            inside_s = middle.from_s;
        }
    }
    return found;
}

scheduled_growth growth_of(const scheduled_loop &loop)
{
    const growth_prediction &found = loop.prediction;
    return {loop.from_s,
            loop.rig.robot.dead_time_ms,
            loop.rig.object.stiffness_N_per_m,
            found.growth_per_s,
            found.ci95_per_s,
            is_stable(found)};
}

/* Loops that follow each other and are all stable, or all unstable. */
struct stretch {
    double from_s;
    const scheduled_growth *worst;
};

std::vector<stretch> stretches_of(const std::vector<scheduled_growth> &schedule)
{
    const bool is_one_jump = schedule.size() == 2; /* both sides are reported, even if they are alike */
    std::vector<stretch> found;
    for (const scheduled_growth &loop : schedule) {
        if (found.empty() || is_one_jump || rank_of(found.back().worst->is_stable) != rank_of(loop.is_stable)) {
            found.push_back({loop.from_s, &loop});
        } else if (found.back().worst->growth_per_s.value_or(0.0) < loop.growth_per_s.value_or(0.0)) {
            found.back().worst = &loop;
        }
    }
    return found;
}

const char *word_of(const scheduled_growth &loop)
{
    static const char *const words[] = {"stable", "of unknown growth", "unstable"};
    return words[rank_of(loop.is_stable)];
}

} // namespace

std::vector<scheduled_loop> loops_of_schedule(const rig &rig, const growth_predictor &predict)
{
    std::vector<scheduled_loop> loops;
    for (const double at_s : instants_of_schedule(rig)) {
        const scheduled_loop loop = loop_at(rig, at_s, predict);
        const bool turns = !loops.empty() && at_s != rig.run.dead_time_jump_s &&
                           rank_of(loops.back().prediction) != rank_of(loop.prediction);
        if (turns) {
            loops.push_back(first_of_a_kind(rig, loops.back(), loop, predict));
        }
        loops.push_back(loop);
    }
    return loops;
}

scheduled_loop worst_of_schedule(const rig &rig, const growth_predictor &predict)
{
    if (!has_schedule(rig)) {
        return {0.0, rig, predict(rig)};
    }
    const std::vector<scheduled_loop> loops = loops_of_schedule(rig, predict);
    const auto found = std::max_element(loops.begin(), loops.end(), is_better);
    scheduled_loop worst = *found;
    for (const scheduled_loop &loop : loops) {
        worst.prediction.schedule.push_back(growth_of(loop));
    }
    return worst;
}

std::string schedule_words(const growth_prediction &prediction)
{
    const std::vector<stretch> stretches = stretches_of(prediction.schedule);
    if (stretches.size() == 1) {
        return std::string(word_of(*stretches[0].worst)) +
               with_numbers(" as long as the loop is closed, worst from %.3g s on", stretches[0].worst->from_s);
    }
    std::string words;
    for (std::size_t i = 0; i < stretches.size(); i++) {
        const scheduled_growth &worst = *stretches[i].worst;
        words += (i > 0 ? ", " : "") + std::string(word_of(worst));
        words += i + 1 == stretches.size() ? " from then on"
                 : i == 0                  ? with_numbers(" before %.3g s", stretches[1].from_s)
                          : with_numbers(" from %.3g to %.3g s", stretches[i].from_s, stretches[i + 1].from_s);
        if (worst.growth_per_s && worst.growth_per_s != prediction.growth_per_s) {
            words += with_numbers(" (%+.3g /s)", *worst.growth_per_s);
        }
    }
    return words;
}

} // namespace berth
