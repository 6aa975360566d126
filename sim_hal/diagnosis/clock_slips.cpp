#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <utility>

#include "../solver/decompositions.h"
#include "clock_slips.h"

namespace berth
{

namespace
{

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

/* The ways in which a clock's drift and phase move without moving the mean lateness, which the dead time makes up
 * for: the drift turns about the middle of the slips, which then stay in their ticks; the phase shifts these. */
class clock_ways
{
  public:
    clock_ways(const fit_result &fitted, const record &data)
    {
        const std::vector<std::size_t> slips = slips_of(fitted.rig, data);
        has_slips = !slips.empty();
        for (const std::size_t slip : slips) {
            pivot_s += data.period_s * static_cast<double>(slip) / static_cast<double>(slips.size());
        }
        const auto dead_time = std::find_if(fitted.parameters.begin(), fitted.parameters.end(),
                                            [](const auto &one) { return one.key->path == "robot.dead_time_ms"; });
        if (dead_time != fitted.parameters.end()) {
            least_ms_ = dead_time->low;
            most_ms_ = dead_time->high;
        }
        middle_s_ = 0.5 * data.period_s * static_cast<double>(data.size());
    }

    void turn(rig &rig, double by_ppm) const
    {
        rig.robot.clock_drift_ppm += by_ppm;
        rig.robot.clock_phase_ms -= 1e-3 * by_ppm * pivot_s;
        make_up(rig, 1e-3 * by_ppm * (middle_s_ - pivot_s));
    }

    void shift(rig &rig, double by_ms) const
    {
        rig.robot.clock_phase_ms += by_ms;
        make_up(rig, by_ms);
    }

    bool has_slips = false;
    double pivot_s = 0.0;

  private:
    void make_up(rig &rig, double late_ms) const
    {
        if (most_ms_ > least_ms_) {
            rig.robot.dead_time_ms = std::min(std::max(rig.robot.dead_time_ms - late_ms, least_ms_), most_ms_);
        }
    }

    double middle_s_ = 0.0;
    double least_ms_ = 0.0;
    double most_ms_ = 0.0;
};

using clock_way = void (clock_ways::*)(rig &, double) const;

/* How far a rig may be moved either way until the white sum of squares has risen by what 95 % allow. */
double reach(block_model &model, const noise_model &noise, const fit_result &fitted, double step,
             const clock_ways &ways, clock_way way)
{
    constexpr int doublings = 24;
    const double rise_max = 3.84 * std::max(1.0, fitted.cost / static_cast<double>(fitted.rows));
    const double least = cost_of(model, noise, fitted.rig);
    double by = step;
    for (int i = 0; i < doublings; i++) {
        double rise = unlimited;
        for (const double sign : {-1.0, 1.0}) {
            rig moved = fitted.rig;
            (ways.*way)(moved, sign * by);
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

void polish_clock(block_model &model, const noise_model &noise, fit_result &fitted)
{
    constexpr int rounds = 40;
    double turn_ppm = 0.05 * std::abs(fitted.rig.robot.clock_drift_ppm);
    double shift_ms = 0.02 * 1e3 * model.data().period_s;
    double least = cost_of(model, noise, fitted.rig);
    for (int round = 0; round < rounds; round++) {
        const clock_ways ways(fitted, model.data());
        if (!ways.has_slips) {
            return;
        }
        bool any = false;
        for (const auto &[way, by] : {std::pair<clock_way, double>{&clock_ways::turn, turn_ppm},
                                      {&clock_ways::turn, -turn_ppm},
                                      {&clock_ways::shift, shift_ms},
                                      {&clock_ways::shift, -shift_ms}}) {
            rig moved = fitted.rig;
            (ways.*way)(moved, by);
            const double cost = cost_of(model, noise, moved);
            if (cost < least) {
                least = cost;
                fitted.rig = moved;
                any = true;
            }
        }
        turn_ppm *= any ? 1.0 : 0.4;
        shift_ms *= any ? 1.0 : 0.4;
    }
    fitted.cost = least;
}

void widen_clock_intervals(block_model &model, const noise_model &noise, fit_result &fitted)
{
    const clock_ways ways(fitted, model.data());
    if (!ways.has_slips || fitted.ci95.size() != fitted.parameters.size()) {
        return; /* then the error is smooth in both */
    }
    const double turn_ppm =
        reach(model, noise, fitted, 1e-6 * std::abs(fitted.rig.robot.clock_drift_ppm), ways, &clock_ways::turn);
    const double shift_ms =
        reach(model, noise, fitted, 1e-6 * 1e3 * model.data().period_s, ways, &clock_ways::shift);
    for (std::size_t i = 0; i < fitted.parameters.size(); i++) {
        const std::string_view key = fitted.parameters[i].key->path;
        if (key == "robot.clock_drift_ppm") {
            fitted.ci95[i] = std::max(fitted.ci95[i], turn_ppm);
        } else if (key == "robot.clock_phase_ms") {
            fitted.ci95[i] = std::max(fitted.ci95[i], std::hypot(shift_ms, 1e-3 * turn_ppm * ways.pivot_s));
        }
    }
}

} // namespace berth
