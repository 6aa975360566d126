#include "events.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "../../../firmware/sensor_layout.h"
#include "../noise/lattice_step.h"
#include "../record/record_gaps.h"

namespace berth
{

namespace
{

bool are_more(std::size_t count, double by_chance)
{
    return count >= events_min && static_cast<double>(count) > 3.0 * by_chance + 5.0 * std::sqrt(by_chance + 1.0);
}

} // namespace

event_finding found_in(const char *name, std::size_t count, std::size_t of)
{
    const double p = static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(of, 1));
    const double tries = static_cast<double>(std::max<std::size_t>(of, 1));
    const double width = 1.96 * std::sqrt(p * (1.0 - p) / tries) + 1.92 / tries; /* about Wilson's */
    return {find_effect(name), {p}, {width}, count};
}

event_finding found_in(const char *name, std::size_t count, const std::vector<std::uint8_t> &rows,
                       const std::vector<std::uint8_t> &counted)
{
    event_finding found = found_in(name, count, count_of(counted));
    std::size_t followed = 0;
    std::size_t after_one = 0;
    for (std::size_t n = 1; n < rows.size(); n++) {
        if (counted[n] != 0 && rows[n - 1] != 0) {
            after_one++;
            followed += rows[n] != 0;
        }
    }
    const double p = found.values[0];
    const auto after = static_cast<double>(after_one);
    found.in_bursts = are_more(followed, p * after);
    if (found.in_bursts) {
        const double correlation = (static_cast<double>(followed) / after - p) / (1.0 - p);
        found.ci95[0] *= std::sqrt((1.0 + correlation) / (1.0 - std::min(correlation, 0.99)));
    }
    return found;
}

namespace
{

/* Rows whose value is that of the row before, in runs of at most `run_max`, while the signal moves by several of its
 * smallest steps about them: so that a step of the wire or an encoder does not look like a repetition. Not at the
 * largest and smallest values, where a limit holds it. */
struct repetitions {
    std::vector<std::uint8_t> rows;    /* empty: no more than by chance */
    std::vector<std::uint8_t> moves;   /* rows that would have told, and that nothing repeats by chance */
    std::vector<std::uint8_t> counted; /* the rows that count, be they repetitions or not */
    std::size_t count = 0;             /* of repetitions among them that are none by chance */
};

std::size_t count_of_both(const std::vector<std::uint8_t> &one, const std::vector<std::uint8_t> &other)
{
    std::size_t count = 0;
    for (std::size_t n = 0; n < one.size(); n++) {
        count += one[n] != 0 && other[n] != 0;
    }
    return count;
}

/* Standard deviation of the noise of a signal that is smooth beside it. */
double noise_sd(const std::vector<double> &x)
{
    std::vector<double> sizes;
    for (std::size_t n = 1; n + 1 < x.size(); n++) {
        sizes.push_back(std::abs(x[n + 1] - 2.0 * x[n] + x[n - 1]));
    }
    return 1.4826 * median_of(sizes) / std::sqrt(6.0);
}

/* That of its steps, which single values off them make no smaller; where it has none, the smallest change. */
double smallest_step(const record &record, const std::vector<double> &x,
                     const std::vector<record_segment> &stretches)
{
    const double step = lattice_step(record.known(x));
    if (step > 0.0) {
        return step;
    }
    double smallest = unlimited;
    for (const record_segment &part : stretches) {
        for (std::size_t n = part.begin + 1; n < part.end; n++) {
            const double change = std::abs(x[n] - x[n - 1]);
            if (change > 0.0) {
                smallest = std::min(smallest, change);
            }
        }
    }
    return smallest;
}

repetitions repeated_rows(const record &record, const std::vector<double> &x)
{
    constexpr std::size_t run_max = 20;
    constexpr double steps_min = 4.0;
    constexpr std::size_t enough = 30; /* to count by them alone */
    std::vector<std::uint8_t> rows(record.size(), 0);
    std::vector<std::uint8_t> chances(record.size(), 0);
    std::vector<std::uint8_t> sure(record.size(), 0);
    /* What was put in for a missing row is off the steps that the others are on, and repeats nothing. */
    std::vector<record_segment> stretches;
    for (const record_segment &segment : record.segments) {
        const auto known = known_stretches(record, segment);
        stretches.insert(stretches.end(), known.begin(), known.end());
    }
    const double smallest = smallest_step(record, x, stretches);
    const auto [least, largest] = std::minmax_element(x.begin(), x.end());
    /* On its way between two samples that are so far apart, one is no exact repetition by chance; where the steps
     * are fine beside the noise, none ever is. */
    const double sd = noise_sd(x);
    const double far = sd > 50.0 * smallest ? 0.0 : 6.0 * sd;
    std::size_t repeats = 0;
    std::size_t single_steps = 0; /* as frequent as repeats by chance, in either direction */
    std::size_t sure_single_steps = 0;
    for (const record_segment &part : stretches) {
        for (std::size_t n = part.begin + 2; n + 1 < part.end;) {
            const double change = std::abs(x[n] - x[n - 1]);
            const bool is_single = change > 0.0 && change < 1.5 * smallest &&
                                   std::abs(x[n - 1] - x[n - 2]) >= steps_min * smallest &&
                                   std::abs(x[n + 1] - x[n]) >= steps_min * smallest;
            single_steps += is_single;
            sure_single_steps += is_single && std::abs(x[n + 1] - x[n - 1]) >= far;
            std::size_t end = n;
            while (end + 1 < part.end && x[end] == x[n - 1]) {
                end++;
            }
            const bool is_short = end > n && end - n <= run_max;
            const double before = std::abs(x[n - 1] - x[n - 2]);
            const double after = std::abs(x[end] - x[n - 1]);
            const bool is_limit = x[n - 1] == *least || x[n - 1] == *largest;
            /* Over two rows, from and to samples that are no repetitions themselves: the same whether n is one or
             * not. */
            std::size_t fresh = std::max(end, n + 1);
            while (fresh + 1 < part.end && x[fresh] == x[n]) {
                fresh++;
            }
            const double beyond = std::abs(x[fresh] - x[n - 1]) * 2.0 / static_cast<double>(fresh - n + 1);
            if (!is_limit && before >= steps_min * smallest && beyond >= steps_min * smallest) {
                /* With the row that ends a run: it was not repeated, and it counts like any other. */
                std::fill(chances.begin() + static_cast<std::ptrdiff_t>(n),
                          chances.begin() + static_cast<std::ptrdiff_t>(end + 1), std::uint8_t{1});
                std::fill(sure.begin() + static_cast<std::ptrdiff_t>(n),
                          sure.begin() + static_cast<std::ptrdiff_t>(end + 1), std::uint8_t{beyond >= far});
            }
            if (is_short && !is_limit && before >= steps_min * smallest && after >= steps_min * smallest) {
                std::fill(rows.begin() + static_cast<std::ptrdiff_t>(n),
                          rows.begin() + static_cast<std::ptrdiff_t>(end), std::uint8_t{1});
                repeats += end - n;
            }
            n = std::max(n + 1, end);
        }
    }
    const std::size_t surely = count_of_both(rows, sure);
    const double by_chance = 0.5 * static_cast<double>(single_steps);
    repetitions told;
    if (are_more(repeats, by_chance)) {
        const std::size_t all = count_of_both(rows, chances);
        const bool are_enough = surely >= enough;
        told.count = are_enough ? surely : all - std::min(all, static_cast<std::size_t>(by_chance));
        told.counted = are_enough ? sure : std::move(chances);
        told.rows = std::move(rows);
    } else if (are_more(surely, 0.5 * static_cast<double>(sure_single_steps))) {
        told.count = surely;
        told.counted = sure;
        std::transform(rows.begin(), rows.end(), sure.begin(), rows.begin(), std::bit_and<>());
        told.rows = std::move(rows);
    }
    told.moves = std::move(sure);
    return told;
}

/* Rows in which both channels are exactly what they were, while one of them at least moves: the tick was lost as a
 * whole. */
struct whole_ticks {
    std::vector<std::uint8_t> rows;
    std::vector<std::uint8_t> counted; /* rows that would have told */
    std::size_t count = 0;             /* 0: no more than by chance */
};

whole_ticks find_whole_ticks(const record &record, const std::vector<std::uint8_t> &robot_moves,
                             const std::vector<std::uint8_t> &force_moves)
{
    whole_ticks found{std::vector<std::uint8_t>(record.size(), 0), std::vector<std::uint8_t>(record.size(), 0)};
    /* One channel may stand still by itself: chance, its resolution, a fault of its own. Begun at one: none seen in
     * few rows is no proof that there are none. */
    double robot_alone = 1.0;
    double force_alone = 1.0;
    double neither = 1.0;
    for (const record_segment &part : record.segments) {
        for (std::size_t n = part.begin + 1; n < part.end; n++) {
            const bool robot = record.robot_position_m[n] == record.robot_position_m[n - 1];
            const bool force = record.force_N[n] == record.force_N[n - 1];
            found.rows[n] = robot && force; /* wherever: once ticks are known to be lost, these most likely are */
            if (robot_moves[n] == 0 && force_moves[n] == 0) {
                continue;
            }
            found.count += robot && force;
            found.counted[n] = 1;
            robot_alone += robot && !force;
            force_alone += force && !robot;
            neither += !force && !robot;
        }
    }
    /* Of channels that know nothing of each other; whole ticks do not add to the three others. */
    if (!are_more(found.count, robot_alone * force_alone / neither)) {
        found.count = 0;
    }
    return found;
}

} // namespace

std::vector<event_finding> find_repeats(const record &record, const rig &given, sample_events &events)
{
    std::vector<event_finding> found;
    repetitions robot_told;
    repetitions force_told;
    if (!record.robot_position_m.empty()) {
        robot_told = repeated_rows(record, record.robot_position_m);
        events.robot_repeats = robot_told.rows;
    }
    if (!record.force_N.empty()) {
        force_told = repeated_rows(record, record.force_N);
        events.force_repeats = force_told.rows;
    }
    std::size_t whole = 0;
    std::size_t force_alone = force_told.count; /* it may lose more by itself */
    if (!record.robot_position_m.empty() && !record.force_N.empty()) {
        const whole_ticks ticks = find_whole_ticks(record, robot_told.moves, force_told.moves);
        whole = ticks.count;
        if (whole > 0) {
            std::size_t together = 0;
            for (std::size_t n = 0; n < force_told.rows.size(); n++) {
                together += force_told.rows[n] != 0 && force_told.counted[n] != 0 && ticks.rows[n] != 0;
            }
            force_alone -= std::min(force_alone, together);
            events.robot_repeats = ticks.rows;
            events.force_repeats.resize(record.size(), 0);
            std::transform(ticks.rows.begin(), ticks.rows.end(), events.force_repeats.begin(),
                           events.force_repeats.begin(), std::bit_or<>());
            found.push_back(found_in("loop.lost_samples", whole, ticks.rows, ticks.counted));
        }
    }
    if (force_alone >= events_min && (whole == 0 || 10 * force_alone >= 3 * whole) &&
        given.sensor.stale_probability == 0.0 && given.bus.loss_probability == 0.0) {
        found.push_back(found_in("sensor.dropouts", force_alone, force_told.rows, force_told.counted));
    }
    return found;
}

std::vector<event_finding> find_quantisation(const record &record, const rig &given, double noise_rms)
{
    const double step = lattice_step(record.known(record.force_N));
    /* q^2/12 is the variance of rounding; it has to be a good part of all that is not explained. */
    const double rounding = step / std::sqrt(12.0);
    const double wire_N = sensor_layouts[given.firmware.sensor_channel.layout].force_step_N;
    const double known_N = std::max(given.sensor.resolution_N, wire_N);
    if (step == 0.0 || known_N > 0.5 * step || rounding * rounding < rounding_share * noise_rms * noise_rms) {
        return {};
    }
    return {{find_effect("sensor.quantisation"), {step}, {1e-3 * step}, record.size()}};
}

} // namespace berth
