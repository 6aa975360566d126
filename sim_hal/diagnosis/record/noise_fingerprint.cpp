#include "noise_fingerprint.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <Eigen/Core>
#include <limits>

#include "../noise/fourier.h"
#include "../noise/lattice_step.h"
#include "../noise/noise.h"
#include "written_digits.h"

namespace berth
{

namespace
{

/* Two measurements share no signs but by chance, 0 +- 1 / sqrt(rows). A copy with as much noise upon it as it has
 * itself shares half of them. What no past explains would have to be as large as the noise, in most rows, for two
 * measurements to share 0.3. */
constexpr double shared_least = 0.3;
constexpr std::size_t overlap_least = 500;

/* The other one, from its `shift` rows on in the first one's rows. */
struct lay {
    std::ptrdiff_t shift = 0;
    std::ptrdiff_t begin = 0; /* of the first one's rows that the other one covers */
    std::ptrdiff_t end = 0;
};

lay lay_of(const std::vector<double> &first, const std::vector<double> &other, std::ptrdiff_t shift)
{
    const auto rows = static_cast<std::ptrdiff_t>(first.size());
    const auto others = static_cast<std::ptrdiff_t>(other.size());
    return {shift, std::max<std::ptrdiff_t>(0, shift), std::min(rows, others + shift)};
}

/* 1 where both have the same sign in the first one's row n, -1 where they differ. */
double sign_of_both(const signal_news &first, const signal_news &other, std::ptrdiff_t n, const lay &at)
{
    return first.signs[static_cast<std::size_t>(n)] * other.signs[static_cast<std::size_t>(n - at.shift)];
}

/* Over the rows in which both have a sign; below zero: more of them differ. */
double shared_at(const signal_news &first, const signal_news &other, const lay &at)
{
    double sum = 0.0;
    double rows = 0.0;
    for (std::ptrdiff_t n = at.begin; n < at.end; n++) {
        const double both = sign_of_both(first, other, n, at);
        sum += both;
        rows += std::abs(both);
    }
    return rows >= static_cast<double>(overlap_least) ? sum / rows : 0.0;
}

/* Sums of the products of the signs at each shift, those below zero at the end. */
std::vector<double> sums_at_shifts(const std::vector<double> &first, const std::vector<double> &other)
{
    std::size_t size = 1;
    while (size < first.size() + other.size()) {
        size *= 2;
    }
    const auto padded = [size](std::vector<double> signs) {
        signs.resize(size, 0.0);
        return signs;
    };
    std::vector<std::complex<double>> lines = spectrum_of(padded(first));
    const std::vector<std::complex<double>> others = spectrum_of(padded(other));
    for (std::size_t i = 0; i < lines.size(); i++) {
        lines[i] *= std::conj(others[i]);
    }
    return values_of(lines);
}

/* Where the signs hang together farthest beyond chance, from a shift of `shift_least` on. */
lay best_lay(const signal_news &first, const signal_news &other, std::ptrdiff_t shift_least)
{
    const std::vector<double> sums = sums_at_shifts(first.signs, other.signs);
    const auto rows = static_cast<std::ptrdiff_t>(first.signs.size());
    const auto others = static_cast<std::ptrdiff_t>(other.signs.size());
    const auto least = static_cast<std::ptrdiff_t>(overlap_least);
    lay best;
    double farthest = 0.0;
    for (std::ptrdiff_t shift = std::max(shift_least, least - others); shift <= rows - least; shift++) {
        const lay tried = lay_of(first.signs, other.signs, shift);
        const auto at =
            static_cast<std::size_t>(shift < 0 ? shift + static_cast<std::ptrdiff_t>(sums.size()) : shift);
        const double far = std::abs(sums[at]) / std::sqrt(static_cast<double>(tried.end - tried.begin));
        if (far > farthest) {
            farthest = far;
            best = tried;
        }
    }
    return best;
}

double step_of(const std::vector<double> &x)
{
    return std::max(lattice_step(x), median_of(units_of_last_digits(x)));
}

/* Noise tells where its steps do not hide it (a rounded normal noise is normal within 3 % from half a step on,
 * Widrow & Kollar 2008), where it is more than what numbers of seven digits leave, and where it is nowhere the same
 * again. */
bool is_telling(const measured_signal &signal, const signal_news &made, double step)
{
    constexpr double least_of_step = 0.58;
    constexpr double least_of_size = 1e-7;
    const Eigen::Map<const Eigen::VectorXd> all(signal.values.data(),
                                                static_cast<Eigen::Index>(signal.values.size()));
    const double size = std::sqrt(all.squaredNorm() / static_cast<double>(all.size()));
    return made.noise_rms > std::max(least_of_step * step, least_of_size * size) &&
           std::abs(shared_at(made, made, best_lay(made, made, 1))) < shared_least;
}

/* Of two signals in different steps, the finer one has what can be told. */
bool can_tell(const measured_signal &first, const signal_news &one, const measured_signal &other,
              const signal_news &two)
{
    const double step = step_of(first.values);
    const double other_step = step_of(other.values);
    return step * two.noise_rms <= other_step * one.noise_rms ? is_telling(first, one, step)
                                                              : is_telling(other, two, other_step);
}

/* What the news of the first one were multiplied by: noise upon the copy leaves the median of the ratios. */
double factor_of(const signal_news &first, const signal_news &other, const lay &at)
{
    std::vector<double> ratios;
    for (std::ptrdiff_t n = at.begin; n < at.end; n++) {
        const double news = first.news[static_cast<std::size_t>(n)];
        if (news != 0.0) {
            ratios.push_back(other.news[static_cast<std::size_t>(n - at.shift)] / news);
        }
    }
    return median_of(std::move(ratios));
}

/* A column of both records that can tell. */
struct column_prints {
    std::size_t column;
    signal_news first;
    signal_news other;
};

/* By what their own past does not tell, whatever it answers to: a command that is repeated with its coarse steps
 * brings them to both in all else that it tells. */
bool share_news_of_own_past(measured_signal first, measured_signal other, const lay &at)
{
    first.cause.clear();
    other.cause.clear();
    return std::abs(shared_at(news_of(first), news_of(other), at)) >= shared_least;
}

/* In most rows both answer to the same command there, or to one turned over, as in the halves of a period that has
 * odd harmonics alone. */
bool is_same_cause(const measured_signal &first, const measured_signal &other, const lay &at)
{
    constexpr double same = 0.1; /* of the largest change: in a closed loop the force's noise moves the command */
    constexpr double most = 0.5; /* of the rows */
    constexpr double as_large = 0.05; /* one that was scaled is another one */
    if (first.cause.empty() || other.cause.empty()) {
        return false;
    }
    double largest = 0.0;
    double product = 0.0;
    for (std::ptrdiff_t n = at.begin + 1; n < at.end; n++) {
        const double here = change(first.cause, static_cast<std::size_t>(n));
        largest = std::max(largest, std::abs(here));
        product += here * change(other.cause, static_cast<std::size_t>(n - at.shift));
    }
    const double sign = product < 0.0 ? -1.0 : 1.0;
    std::ptrdiff_t rows = 0;
    double shared = 0.0; /* product and square over the rows that are the same */
    double square = 0.0;
    for (std::ptrdiff_t n = at.begin + 1; n < at.end; n++) {
        const double here = change(first.cause, static_cast<std::size_t>(n));
        const double there = sign * change(other.cause, static_cast<std::size_t>(n - at.shift));
        if (std::abs(here - there) <= same * largest) {
            rows++;
            shared += here * there;
            square += here * here;
        }
    }
    return static_cast<double>(rows) > most * static_cast<double>(at.end - at.begin - 1) &&
           std::abs(shared - square) <= as_large * square;
}

/* The mean squares of the news over stretches, sorted, and the signs that both share in the quietest of them. */
struct quiet_stretches {
    std::vector<double> squares;
    double share = 0.0;
};

quiet_stretches quiet_stretches_of(const signal_news &first, const signal_news &other, const lay &at)
{
    constexpr std::ptrdiff_t stretch = 32; /* rows, over which the rms of noise is known to an eighth */
    std::vector<std::pair<double, std::ptrdiff_t>> found;
    for (std::ptrdiff_t begin = at.begin; begin + stretch <= at.end; begin += stretch) {
        double square = 0.0;
        for (std::ptrdiff_t n = begin; n < begin + stretch; n++) {
            square += std::pow(first.news[static_cast<std::size_t>(n)], 2);
        }
        found.emplace_back(square, begin);
    }
    std::sort(found.begin(), found.end());
    quiet_stretches made;
    double sum = 0.0;
    double rows = 0.0;
    for (const auto &[square, begin] : found) {
        if (made.squares.size() <= found.size() / 10) {
            for (std::ptrdiff_t n = begin; n < begin + stretch; n++) {
                const double both = sign_of_both(first, other, n, at);
                sum += both;
                rows += std::abs(both);
            }
        }
        made.squares.push_back(square);
    }
    made.share = rows > 0.0 ? std::abs(sum / rows) : 0.0;
    return made;
}

/* Noise is about as large all along, what steps and jerks of a motion bring is not. */
bool is_even(const std::vector<double> &sorted_squares)
{
    constexpr double even = 2.0; /* of noise 1.7 */
    const std::size_t few = sorted_squares.size() / 50;
    return sorted_squares.empty() ||
           sorted_squares[sorted_squares.size() - 1 - few] < even * even * sorted_squares[few];
}

/* A copy, but for what rounds both. */
bool differ_by_rounding(const measured_signal &first, const measured_signal &other, const lay &at)
{
    constexpr double of_step = 0.8; /* rms of a change: 0.6 where both are rounded, 1.2 beside noise that can tell */
    double square = 0.0;
    double product = 0.0;
    double square_of_other = 0.0;
    for (std::ptrdiff_t n = at.begin + 1; n < at.end; n++) {
        const double here = change(first.values, static_cast<std::size_t>(n));
        const double there = change(other.values, static_cast<std::size_t>(n - at.shift));
        square += here * here;
        product += here * there;
        square_of_other += there * there;
    }
    const double factor = product / square;
    const double rms =
        std::sqrt(std::max(0.0, square_of_other - factor * product) / static_cast<double>(at.end - at.begin - 1));
    return rms <= of_step * std::max(step_of(first.values) * std::abs(factor), step_of(other.values));
}

/* Nor is it often far off its own size: that of a normal distribution is 1, in 0.2 N of noise on the force and in 5
 * um on a robot without play 1.0 to 1.1, in the jerks of one with play 3 and more. */
bool is_of_one_size(const signal_news &news, const lay &at)
{
    constexpr double most = 1.5; /* rms over the spread that most rows have */
    double square = 0.0;
    for (std::ptrdiff_t n = at.begin; n < at.end; n++) {
        square += std::pow(news.news[static_cast<std::size_t>(n)], 2);
    }
    return std::sqrt(square / static_cast<double>(at.end - at.begin)) < most * news.noise_rms;
}

/* Two measurements of the same command have all in common that it brings about, be it as jerky as steps, play and a
 * dead band make it: only noise is their own. Where the news are quietest they are noise, or nearly so; a copy
 * shares them there, too, and what differs by no more than rounding is one. */
bool may_be_repetition(const measured_signal &first, const signal_news &news, const measured_signal &other,
                       const signal_news &other_news, const lay &at)
{
    constexpr double nearly_all = 0.9;
    if (!is_same_cause(first, other, at)) {
        return false;
    }
    const quiet_stretches quiet = quiet_stretches_of(news, other_news, at);
    const bool is_noise = is_even(quiet.squares) && is_of_one_size(news, at);
    return quiet.share < (is_noise ? shared_least : nearly_all);
}

/* What a column says of a lay, in the order in which it speaks for a copy. */
enum class likeness { of_its_own, may_be_repetition, copied, the_same };

likeness likeness_of(const measured_signal &first, const signal_news &news, const measured_signal &other,
                     const signal_news &other_news, const lay &at)
{
    if (std::abs(shared_at(news, other_news, at)) < shared_least || !share_news_of_own_past(first, other, at)) {
        return likeness::of_its_own;
    }
    if (differ_by_rounding(first, other, at)) {
        return likeness::the_same;
    }
    return may_be_repetition(first, news, other, other_news, at) ? likeness::may_be_repetition : likeness::copied;
}

/* The lay that one column shows: where every other one shows it, too, and the last one, which no other one drives,
 * beyond what a repeated command makes alike; or where one is the same but for rounding. */
std::optional<copy_found> copy_of(const std::vector<column_prints> &columns,
                                  const std::vector<measured_signal> &first,
                                  const std::vector<measured_signal> &others, bool is_backwards)
{
    for (const column_prints &column : columns) {
        const lay at = best_lay(column.first, column.other, std::numeric_limits<std::ptrdiff_t>::min());
        std::vector<likeness> found;
        found.reserve(columns.size());
        for (const column_prints &each : columns) {
            found.push_back(likeness_of(first[each.column], each.first,
                                        is_backwards ? others[each.column].backwards() : others[each.column],
                                        each.other, at));
        }
        const auto [least, most] = std::minmax_element(found.begin(), found.end());
        if ((*least > likeness::of_its_own && found.back() >= likeness::copied) || *most == likeness::the_same) {
            const column_prints &which =
                *most == likeness::the_same ? columns[static_cast<std::size_t>(most - found.begin())] : column;
            const auto rows = static_cast<std::ptrdiff_t>(column.other.signs.size());
            return copy_found{which.column, is_backwards ? at.shift + rows - 1 : at.shift, is_backwards,
                              factor_of(which.first, which.other, at)};
        }
    }
    return {};
}

} // namespace

std::optional<copy_found> find_copy(const std::vector<measured_signal> &first,
                                    const std::vector<measured_signal> &others)
{
    std::vector<column_prints> columns;
    for (std::size_t i = 0; i < first.size(); i++) {
        if (std::min(first[i].values.size(), others[i].values.size()) < overlap_least) {
            continue;
        }
        column_prints both = {i, news_of(first[i]), news_of(others[i])};
        if (can_tell(first[i], both.first, others[i], both.other)) {
            columns.push_back(std::move(both));
        }
    }
    const auto forwards = copy_of(columns, first, others, false);
    if (forwards) {
        return forwards;
    }
    for (column_prints &both : columns) {
        both.other = news_of(others[both.column].backwards());
    }
    return copy_of(columns, first, others, true);
}

} // namespace berth
