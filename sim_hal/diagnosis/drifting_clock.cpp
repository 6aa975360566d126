#include "drifting_clock.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <functional>
#include <utility>

#include "../solver/decompositions.h"

namespace berth
{

namespace
{

/* Mean lateness of a part of the record, from error = -late velocity, and how well it is known. */
struct lateness {
    double time_s;
    double late_s;
    double weight;
};

std::vector<lateness> lateness_over_time(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s)
{
    const std::size_t length = std::max<std::size_t>(10, static_cast<std::size_t>(0.2 / period_s));
    std::vector<lateness> parts;
    parts.reserve(error.size() / length);
    for (std::size_t begin = 1; begin + length < error.size(); begin += length) {
        double both = 0.0;
        double square = 0.0;
        for (std::size_t n = begin; n < begin + length; n++) {
            const double velocity = (position_m[n + 1] - position_m[n - 1]) / (2.0 * period_s);
            both -= error[n] * velocity;
            square += velocity * velocity;
        }
        if (square > 0.0) {
            const double middle = static_cast<double>(begin) + 0.5 * static_cast<double>(length);
            parts.push_back({middle * period_s, both / square, square});
        }
    }
    return parts;
}

/* Weighted square of what a sawtooth leaves; its mean is free, as the dead time is. */
double left_by(const std::vector<lateness> &parts, double drift, double phase_s, double period_s)
{
    double weight = 0.0;
    double sum = 0.0;
    double square = 0.0;
    for (const lateness &part : parts) {
        const double way = (phase_s + drift * part.time_s) / period_s;
        const double rest = part.late_s - period_s * (way - std::floor(way));
        weight += part.weight;
        sum += part.weight * rest;
        square += part.weight * rest * rest;
    }
    return weight > 0.0 ? square - sum * sum / weight : 0.0;
}

/* Rows in which the clock slips: its lateness passes a whole period. */
std::vector<std::size_t> slips_of(const rig &rig, const record &data)
{
    constexpr std::size_t many = 1000;
    const double period_ms = 1e3 * data.period_s;
    const double drift_ms_per_s = 1e-3 * rig.robot.clock_drift_ppm;
    const double begin_s = data.time_s.front() - data.time_origin_s;
    const double end_s = data.time_s.back() - data.time_origin_s;
    const auto periods_late = [&](double time_s) {
        return (rig.robot.clock_phase_ms + drift_ms_per_s * time_s) / period_ms;
    };
    const double first = std::min(periods_late(begin_s), periods_late(end_s));
    const double last = std::max(periods_late(begin_s), periods_late(end_s));
    std::vector<std::size_t> rows;
    double whole = std::ceil(first);
    while (whole < last && rows.size() < many) {
        const double time_s = (whole * period_ms - rig.robot.clock_phase_ms) / drift_ms_per_s;
        rows.push_back(static_cast<std::size_t>((time_s - begin_s) / data.period_s));
        whole++;
    }
    return rows;
}

} // namespace

namespace
{

/* A sawtooth: how many periods it drifts over the record, and which share of the way to its first slip it has behind
 * it at the start. Of a slow one, that slips once or never, the share is of the way that it goes in the record. */
struct sawtooth {
    double wraps;
    double share; /* above 1, of a slow one: no slip */
    double left = unlimited;
};

clock_guess guess_of(const sawtooth &tooth, double duration_s, double period_s)
{
    const double way = std::min(1.0, std::abs(tooth.wraps)) * tooth.share;
    const double phase = tooth.wraps > 0.0 ? 1.0 - way : way;
    return {1e6 * tooth.wraps * period_s / duration_s, 1e3 * period_s * (phase - std::floor(phase))};
}

/* Halves its steps where no neighbour is better. */
void refine(sawtooth &tooth, double wraps_step, double share_step, const std::function<double(const sawtooth &)> &left)
{
    constexpr int rounds = 16;
    for (int round = 0; round < rounds; round++) {
        const sawtooth here = tooth;
        for (const auto &[wraps, share] :
             {std::pair{wraps_step, 0.0}, {-wraps_step, 0.0}, {0.0, share_step}, {0.0, -share_step}}) {
            sawtooth tried{here.wraps + wraps, here.share + share};
            tried.left = left(tried);
            if (tried.left < tooth.left) {
                tooth = tried;
            }
        }
        if (tooth.left == here.left) {
            wraps_step *= 0.5;
            share_step *= 0.5;
        }
    }
}

} // namespace

std::vector<clock_guess> drifting_clocks(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s, int count)
{
    constexpr int wraps_max = 30; /* of the sawtooth over the record, either way */
    constexpr int steps_a_wrap = 8;
    constexpr int shares = 16;
    constexpr std::size_t refined = 24;
    const std::vector<lateness> parts = lateness_over_time(error, position_m, period_s);
    if (parts.empty()) {
        return {};
    }
    const double duration_s = period_s * static_cast<double>(error.size());
    const auto left = [&](const sawtooth &tooth) {
        const clock_guess guess = guess_of(tooth, duration_s, period_s);
        return left_by(parts, 1e-6 * guess.drift_ppm, 1e-3 * guess.phase_ms, period_s);
    };
    std::vector<double> sizes = {1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0};
    for (int i = 1; i <= wraps_max * steps_a_wrap; i++) {
        sizes.push_back(static_cast<double>(i) / steps_a_wrap);
    }
    std::vector<sawtooth> trials;
    trials.reserve(2 * sizes.size());
    for (const double size : sizes) {
        for (const double wraps : {-size, size}) {
            sawtooth best{wraps, 0.0};
            const int tried = size < 1.0 ? shares + 1 : shares; /* one without a slip */
            for (int k = 0; k < tried; k++) {
                sawtooth one{wraps, (k + 0.5) / shares};
                one.left = left(one);
                best = one.left < best.left ? one : best;
            }
            trials.push_back(best);
        }
    }
    const auto is_better = [](const sawtooth &a, const sawtooth &b) { return a.left < b.left; };
    std::sort(trials.begin(), trials.end(), is_better);
    trials.resize(std::min(trials.size(), refined));
    for (sawtooth &one : trials) {
        refine(one, 0.25 * std::abs(one.wraps) / std::max(1.0, 2.0 * std::abs(one.wraps)), 0.25 / shares, left);
    }
    std::sort(trials.begin(), trials.end(), is_better);
    std::vector<clock_guess> guesses;
    for (const sawtooth &one : trials) {
        const clock_guess guess = guess_of(one, duration_s, period_s);
        const bool is_known = std::any_of(guesses.begin(), guesses.end(), [&](const clock_guess &other) {
            return std::abs(other.drift_ppm - guess.drift_ppm) < 0.02 * std::abs(guess.drift_ppm) &&
                   std::abs(other.phase_ms - guess.phase_ms) < 20.0 * period_s; /* a fiftieth of the period */
        });
        if (!is_known && guesses.size() < static_cast<std::size_t>(count)) {
            guesses.push_back(guess);
        }
    }
    return guesses;
}

namespace
{

/* By how many ticks, in halves, a slip may be off either way. */
constexpr int half_ticks = 48;

/* In which rows a stiff contact shows that a slip is in another tick. */
std::vector<record_segment> answers_to_slips(const rig &rig, const record &data)
{
    constexpr std::size_t before = half_ticks / 2 + 6;
    constexpr double answer_s = 0.2;
    const std::size_t after = before + static_cast<std::size_t>(answer_s / data.period_s);
    std::vector<record_segment> answers;
    for (const std::size_t slip : slips_of(rig, data)) {
        answers.push_back({slip - std::min(slip, before), std::min(data.size(), slip + after)});
    }
    return answers;
}

bool leaves_enough(const std::vector<record_segment> &answers, const record &data)
{
    return !answers.empty() && answers.size() * (answers.front().end - answers.front().begin) < data.size() / 2;
}

/* Phase and drift that make each slip so many ticks later. */
void shift_slips(rig &rig, const record &data, const std::vector<record_segment> &answers,
                 const std::vector<double> &ticks)
{
    const auto count = static_cast<Eigen::Index>(answers.size());
    Eigen::MatrixXd basis = Eigen::MatrixXd::Ones(count, count > 1 ? 2 : 1);
    Eigen::VectorXd late_ms(count);
    for (Eigen::Index k = 0; k < count; k++) {
        const auto slip = static_cast<std::size_t>(k);
        late_ms(k) = ticks[slip] * 1e-3 * rig.robot.clock_drift_ppm * data.period_s;
        if (count > 1) {
            basis(k, 1) = data.time_s[answers[slip].begin] - data.time_origin_s;
        }
    }
    const Eigen::VectorXd line = least_squares_solution(basis, late_ms);
    rig.robot.clock_phase_ms += line(0);
    rig.robot.clock_drift_ppm += count > 1 ? 1e3 * line(1) : 0.0;
}

} // namespace

std::vector<row_use> uses_beside_slips(const block_model &model, const rig &rig)
{
    std::vector<row_use> uses = model.uses();
    const std::vector<record_segment> answers = answers_to_slips(rig, model.data());
    if (leaves_enough(answers, model.data())) {
        for (const record_segment &answer : answers) {
            std::fill(uses.begin() + static_cast<std::ptrdiff_t>(answer.begin),
                      uses.begin() + static_cast<std::ptrdiff_t>(answer.end), row_use::none);
        }
    }
    return uses;
}

void match_slips(block_model &force, rig &rig)
{
    const record &data = force.data();
    const std::vector<record_segment> answers = answers_to_slips(rig, data);
    if (!leaves_enough(answers, data)) {
        return;
    }
    const double tick_ms = 1e-3 * rig.robot.clock_drift_ppm * data.period_s; /* of lateness */
    std::vector<double> least(answers.size(), unlimited);
    std::vector<double> off(answers.size(), 0.0); /* ticks */
    std::vector<double> error;
    for (int i = 0; i <= 2 * half_ticks; i++) {
        const double ticks = 0.5 * (i % 2 == 0 ? i / 2 : -(i + 1) / 2); /* nearest first */
        berth::rig moved = rig;
        moved.robot.clock_phase_ms += ticks * tick_ms;
        force.error(moved, error);
        for (std::size_t slip = 0; slip < answers.size(); slip++) {
            double square = 0.0;
            for (std::size_t n = answers[slip].begin; n < answers[slip].end; n++) {
                square += error[n] * error[n];
            }
            if (square < least[slip]) {
                least[slip] = square;
                off[slip] = ticks;
            }
        }
    }
    shift_slips(rig, data, answers, off);
}

namespace
{

/* How far, in units of `step`, a rig may be moved either way until the white sum of squares has risen by what 95 %
 * allow. */
double reach(block_model &model, const noise_model &noise, const fit_result &fitted, double step,
             const std::function<void(rig &, double)> &move)
{
    constexpr int doublings = 24;
    const double rise_max = 3.84 * std::max(1.0, fitted.cost / static_cast<double>(fitted.rows));
    const double least = cost_of(model, noise, fitted.rig);
    double by = step;
    for (int i = 0; i < doublings; i++) {
        double rise = unlimited;
        for (const double sign : {-1.0, 1.0}) {
            rig moved = fitted.rig;
            move(moved, sign * by);
            rise = std::min(rise, cost_of(model, noise, moved) - least);
        }
        if (rise > rise_max) {
            break;
        }
        by *= 2.0;
    }
    return by;
}

} // namespace

void widen_clock_intervals(block_model &model, const noise_model &noise, fit_result &fitted)
{
    const rig &rig = fitted.rig;
    const std::vector<std::size_t> slips = slips_of(rig, model.data());
    if (slips.empty() || fitted.ci95.size() != fitted.parameters.size()) {
        return; /* then the error is smooth in both */
    }
    double pivot_s = 0.0;
    for (const std::size_t slip : slips) {
        pivot_s += model.data().period_s * static_cast<double>(slip) / static_cast<double>(slips.size());
    }
    const double drift_ppm = reach(model, noise, fitted, 1e-6 * std::abs(rig.robot.clock_drift_ppm),
                                   [&](berth::rig &moved, double by_ppm) {
                                       moved.robot.clock_drift_ppm += by_ppm;
                                       moved.robot.clock_phase_ms -= 1e-3 * by_ppm * pivot_s;
                                   });
    const double slips_ms =
        reach(model, noise, fitted, 1e-6 * 1e3 * model.data().period_s,
              [](berth::rig &moved, double by_ms) { moved.robot.clock_phase_ms += by_ms; });
    for (std::size_t i = 0; i < fitted.parameters.size(); i++) {
        const std::string_view key = fitted.parameters[i].key->path;
        if (key == "robot.clock_drift_ppm") {
            fitted.ci95[i] = std::max(fitted.ci95[i], drift_ppm);
        } else if (key == "robot.clock_phase_ms") {
            fitted.ci95[i] = std::max(fitted.ci95[i], std::hypot(slips_ms, 1e-3 * drift_ppm * pivot_s));
        }
    }
}

} // namespace berth
