#include "schedule.h"

#include <algorithm>
#include <cmath>

#include "../hal/rig/axes.h"
#include "../hal/rig/rig_file.h"
#include "effects/active.h"
#include "stability/loop_timeline.h"
#include "verdict_words.h"

namespace berth
{

namespace
{

constexpr const char *dead_time_drift = "robot.dead_time_drift_ms_per_s";
constexpr const char *stiffness_drift = "object.stiffness_drift_per_s";

/* A drift is looked at in so many steps: a stable or unstable stretch shorter than one may be overlooked. */
constexpr int drift_steps = 16;
constexpr int drift_steps_if_slow = 4; /* each takes a good part of a second */
constexpr double exact_share = 0.01;   /* of the run */

bool drifts(const rig &rig)
{
    return value_of_effect(rig, dead_time_drift) != 0.0 || value_of_effect(rig, stiffness_drift) != 0.0;
}

struct time_span {
    double from_s;
    double to_s;
};

/* In which the loop is closed. */
time_span closed_span(const run_rig &run)
{
    return {std::max(run.release_s, run.grip_close_s),
            std::min({run.duration_s, run.grip_release_s, run.emergency_stop_s, run.enable_off_s})};
}

bool jumps_within(const rig &rig, const time_span &closed)
{
    return rig.run.dead_time_jump_ms != 0.0 && rig.run.dead_time_jump_s < closed.to_s;
}

/* As robot.cpp has it: a dead time that drifts stays longer than a period. */
double dead_time_ms(const rig &rig, double at_s)
{
    const double told_ms =
        rig.robot.dead_time_ms + (at_s < rig.run.dead_time_jump_s ? 0.0 : rig.run.dead_time_jump_ms);
    const double drift_ms = value_of_effect(rig, dead_time_drift) * at_s;
    const double shortest_ms = std::min(rig.robot.dead_time_ms, 1e3 * config_period_s(&rig.firmware));
    return drift_ms == 0.0 ? told_ms : std::max(told_ms + drift_ms, shortest_ms);
}

/* The firmware goes on with what it was told. */
rig rig_at(const rig &original, double at_s)
{
    rig made = original;
    made.run.dead_time_jump_s = never;
    made.run.dead_time_jump_ms = 0.0;
    move_dead_time(made, dead_time_ms(original, at_s));
    made.object.stiffness_N_per_m *= 1.0 + value_of_effect(original, stiffness_drift) * at_s;
    set_number(made, dead_time_drift, 0.0);
    set_number(made, stiffness_drift, 0.0);
    return made;
}

/* Why the loop at an instant cannot be predicted; empty: it can. */
std::string reason_against(const rig &original, const rig &at)
{
    if (at.object.kind == object_kind::beam && value_of_effect(original, stiffness_drift) != 0.0) {
        return "object.stiffness_drift_per_s changes no single mode of a beam: run it";
    }
    if (at.object.stiffness_N_per_m < 0.0) {
        return "object.stiffness_drift_per_s leaves the object a stiffness below 0";
    }
    if (at.robot.dead_time_ms < std::min(original.robot.dead_time_ms, 2e3 * config_period_s(&at.firmware))) {
        return "robot.dead_time_drift_ms_per_s leaves the robot a dead time below 2 periods";
    }
    return {};
}

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

bool has_schedule(const rig &rig)
{
    const time_span closed = closed_span(rig.run);
    return !touches_nothing(rig) && closed.from_s < closed.to_s && (jumps_within(rig, closed) || drifts(rig));
}

std::vector<scheduled_loop> loops_of_schedule(const rig &rig, const growth_predictor &predict)
{
    const time_span closed = closed_span(rig.run);
    std::vector<double> times_s{closed.from_s};
    if (jumps_within(rig, closed) && rig.run.dead_time_jump_s > closed.from_s) {
        times_s.push_back(rig.run.dead_time_jump_s);
    }
    if (drifts(rig)) {
        const int steps = is_time_varying(rig) ? drift_steps_if_slow : drift_steps;
        for (int i = 1; i <= steps; i++) {
            times_s.push_back(closed.from_s + (closed.to_s - closed.from_s) * i / steps);
        }
        std::sort(times_s.begin(), times_s.end());
        times_s.erase(std::unique(times_s.begin(), times_s.end()), times_s.end());
    }
    std::vector<scheduled_loop> loops;
    for (const double at_s : times_s) {
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
