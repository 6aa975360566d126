#include "drifting_clock.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>

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

std::vector<clock_guess> drifting_clocks(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s, int count)
{
    constexpr int wraps_max = 30; /* of the sawtooth over the record, either way */
    constexpr int steps_a_wrap = 8;
    constexpr int phases = 16;
    const std::vector<lateness> parts = lateness_over_time(error, position_m, period_s);
    struct trial {
        clock_guess guess;
        double left;
    };
    std::vector<trial> trials;
    constexpr std::size_t drifts = 2 * wraps_max * steps_a_wrap + 1;
    trials.reserve(drifts);
    const double duration_s = period_s * static_cast<double>(error.size());
    for (int i = -wraps_max * steps_a_wrap; i <= wraps_max * steps_a_wrap; i++) {
        const double drift = i * period_s / (steps_a_wrap * duration_s);
        trial best{{}, unlimited};
        for (int k = 0; k < phases; k++) {
            const double phase_s = (k + 0.5) * period_s / phases;
            const double left = left_by(parts, drift, phase_s, period_s);
            if (left < best.left) {
                best = {{1e6 * drift, 1e3 * phase_s}, left};
            }
        }
        if (i != 0) {
            trials.push_back(best);
        }
    }
    std::sort(trials.begin(), trials.end(), [](const trial &a, const trial &b) { return a.left < b.left; });
    std::vector<clock_guess> guesses;
    for (std::size_t i = 0; i < trials.size() && i < static_cast<std::size_t>(count); i++) {
        guesses.push_back(trials[i].guess);
    }
    return parts.empty() ? std::vector<clock_guess>{} : guesses;
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

} // namespace berth
