#include "independent_records.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "../../../hal/rig/rig_file.h"
#include "../../solver/decompositions.h"
#include "../formatted.h"
#include "noise_fingerprint.h"

namespace berth
{

namespace
{

using signal = std::vector<double>;

/* The second half of a record, laid on the first. */
struct turn {
    bool is_mirrored;
    double sign;

    /* Row of the second half that lies on row `n` of the first, `shift` rows later. */
    std::ptrdiff_t partner(std::size_t n, std::size_t size, std::ptrdiff_t shift) const
    {
        const auto row = static_cast<std::ptrdiff_t>(is_mirrored ? size - 1 - n : size - size / 2 + n);
        return row + shift;
    }
};

constexpr turn turns[] = {{false, 1.0}, {false, -1.0}, {true, 1.0}, {true, -1.0}};

/* All but a tenth of the rows are the same to the last digits, and they are no pause. */
bool is_exact(const signal &x, const turn &how)
{
    const std::size_t half = x.size() / 2;
    std::size_t same = 0;
    std::size_t changes = 0;
    for (std::size_t n = 1; n < half; n++) {
        const double other = x[static_cast<std::size_t>(how.partner(n, x.size(), 0))];
        same += std::abs(x[n] - how.sign * other) <= 1e-9 * std::abs(x[n]);
        changes += x[n] != x[n - 1];
    }
    return 2 * changes > half && 10 * same > 9 * half;
}

/* rms by which the halves differ, of that of the signal about its mean. */
double difference(const signal &x, const turn &how, std::ptrdiff_t shift)
{
    const auto size = static_cast<std::ptrdiff_t>(x.size());
    const Eigen::Map<const Eigen::VectorXd> all(x.data(), size);
    double square = 0.0;
    double rows = 0.0;
    for (std::size_t n = 0; n < x.size() / 2; n++) {
        const std::ptrdiff_t other = how.partner(n, x.size(), shift);
        if (other >= 0 && other < size) {
            square += std::pow(x[n] - how.sign * x[static_cast<std::size_t>(other)], 2);
            rows += 1.0;
        }
    }
    const double variance = (all.array() - all.mean()).square().mean();
    return variance > 0.0 && rows > 0.0 ? std::sqrt(square / rows / variance) : unlimited;
}

/* Student's t of how a response goes with the rate of its cause beyond what depends on the cause's value alone: a
 * lag or a friction makes it significant, and its sign turns with the direction of time. */
double direction_of_time(const signal &response, const signal &cause, std::size_t begin, std::size_t end)
{
    constexpr Eigen::Index parts = 16;
    const auto rows = static_cast<Eigen::Index>(end - begin - 2);
    Eigen::MatrixXd values(rows, 4);
    Eigen::MatrixXd both(rows, 2);
    double largest = 1e-300;
    for (std::size_t n = begin; n < end; n++) {
        largest = std::max(largest, std::abs(cause[n]));
    }
    for (Eigen::Index i = 0; i < rows; i++) {
        const std::size_t n = begin + 1 + static_cast<std::size_t>(i);
        const double c = cause[n] / largest;
        values.row(i) << 1.0, c, c * c, c * c * c;
        both.row(i) << response[n], cause[n + 1] - cause[n - 1];
    }
    const Eigen::MatrixXd rest = both - values * least_squares_solution(values, both);
    Eigen::VectorXd sums(parts);
    Eigen::VectorXd energies(parts);
    for (Eigen::Index part = 0; part < parts; part++) {
        const Eigen::Index first = part * rows / parts;
        const Eigen::Index count = (part + 1) * rows / parts - first;
        sums(part) = rest.col(0).segment(first, count).dot(rest.col(1).segment(first, count));
        energies(part) = rest.col(1).segment(first, count).squaredNorm();
    }
    /* A motion that dies away has less in the later parts, and that is no chance. */
    const Eigen::VectorXd expected = energies * (sums.sum() / std::max(energies.sum(), 1e-300));
    const double variance = (sums - expected).squaredNorm() / (parts - 1.0);
    return variance > 0.0 ? sums.mean() / std::sqrt(variance / parts) : 0.0;
}

/* No noise makes t that large in both halves: it is below 4 where nothing lags, above 6 for a lag of 2 ms at 1 %
 * noise. */
constexpr double significant = 5.0;
constexpr double nearly_the_same = 0.1;

/* The response runs backwards against its cause. */
bool runs_backwards(const signal &response, const signal &cause)
{
    const std::size_t half = response.size() / 2;
    const double first = direction_of_time(response, cause, 0, half);
    const double second = direction_of_time(response, cause, response.size() - half, response.size());
    return std::min(std::abs(first), std::abs(second)) > significant && first * second < 0.0;
}

/* The command does not do again what the robot does again, whatever the robot's delay. */
bool lacks_a_cause(const signal &command, const turn &how, double difference_of_response, double period_s)
{
    constexpr double differs = 0.15; /* of the command's rms */
    constexpr double by_far = 5.0;
    constexpr double delay_max_s = 1.0;
    const double least = std::max(differs, by_far * difference_of_response);
    const auto shift_max =
        static_cast<std::ptrdiff_t>(std::min(delay_max_s / period_s, 0.25 * static_cast<double>(command.size())));
    for (std::ptrdiff_t shift = -shift_max; shift <= shift_max; shift++) {
        if (difference(command, how, shift) < least) {
            return false;
        }
    }
    return true;
}

/* With the noise of a measurement on the copy. */
bool is_noisy_copy(const record &record, const signal &response, const signal &cause, const turn &how)
{
    const double differs = difference(response, how, 0);
    if (cause.size() != response.size() || differs > nearly_the_same) {
        return false;
    }
    const bool is_robot = &response == &record.robot_position_m;
    /* Of a manipulator it is the push that shows the damping: of a mass the motion hardly follows the push's rate.
     */
    const bool is_manipulator = &response == &record.command_position_m;
    return (how.is_mirrored &&
            (runs_backwards(response, cause) || (is_manipulator && runs_backwards(cause, response)))) ||
           (is_robot && lacks_a_cause(cause, how, differs, record.period_s));
}

struct measured_column {
    const char *name;
    signal record::*values;
};

constexpr measured_column force_column = {"force_N", &record::force_N};
constexpr measured_column robot_column = {"robot_position_m", &record::robot_position_m};
constexpr measured_column command_column = {"command_position_m", &record::command_position_m};

bool shows_answer(const record &record)
{
    return !record.force_N.empty() || !record.robot_position_m.empty();
}

/* Of both records. Where neither shows an answer to the command, that is itself what was measured. */
std::vector<measured_column> measured_columns(const record &first, const record &other)
{
    if (!shows_answer(first) && !shows_answer(other)) {
        return {command_column};
    }
    const bool is_robot_cause = first.moves_as_measured() || other.moves_as_measured();
    std::vector<measured_column> found;
    for (const measured_column &column : {force_column, robot_column}) {
        if (column.values == robot_column.values && is_robot_cause) {
            continue;
        }
        if (!(first.*column.values).empty() && !(other.*column.values).empty()) {
            found.push_back(column);
        }
    }
    return found;
}

/* Rows from `begin` up to `end` of each column, and what it answers to. */
std::vector<measured_signal> rows_of(const record &record, const std::vector<measured_column> &columns,
                                     std::size_t begin, std::size_t end)
{
    const auto part = [begin, end](const auto &x) {
        using values = std::decay_t<decltype(x)>;
        return x.empty() ? values()
                         : values(x.begin() + static_cast<std::ptrdiff_t>(begin),
                                  x.begin() + static_cast<std::ptrdiff_t>(end));
    };
    std::vector<measured_signal> found;
    for (const measured_column &column : columns) {
        const bool is_command = column.values == command_column.values;
        found.push_back({part(record.*column.values),
                         part(is_command ? record.operator_force_N : record.command_position_m),
                         part(record.filled)});
    }
    return found;
}

/* As ", backwards, turned over, times 1.5". */
std::string words_of(const copy_found &how)
{
    constexpr double as_is = 0.05; /* about what noise leaves of a factor */
    const double size = std::abs(how.factor);
    return std::string(how.is_backwards ? ", backwards" : "") + (how.factor < 0.0 ? ", turned over" : "") +
           (std::abs(size - 1.0) > as_is ? formatted(", times %.2g", size) : "");
}

/* Of a copy that is not exact and has its commands again, too. */
void refuse_noise_of_first_half(const record &record)
{
    const std::size_t half = record.size() / 2;
    const std::vector<measured_column> columns = measured_columns(record, record);
    const auto copy =
        find_copy(rows_of(record, columns, 0, half), rows_of(record, columns, record.size() - half, record.size()));
    if (copy) {
        throw input_error(
            record.path + ": " + columns[copy->column].name + " has in its second half the noise of its first one" +
            words_of(*copy) +
            ": held-out data that is no independent evidence; give a record that was measured in one go");
    }
}

} // namespace

void refuse_copies(const record &record)
{
    constexpr std::size_t half_least = 40;
    const std::pair<const signal *, const signal *> pairs[] = {
        {&record.force_N, &record.command_position_m},
        {&record.robot_position_m, &record.command_position_m},
        {&record.command_position_m, &record.operator_force_N}};
    for (const auto &[response, cause] : pairs) {
        if (response != &record.force_N && record.moves_as_measured()) {
            continue; /* what was measured is the cause */
        }
        for (const turn &how : turns) {
            /* A command that does the same again is a good one: only its answer must not. Without one it is itself
             * what was measured. */
            const bool may_repeat = response == &record.command_position_m &&
                                    !(record.robot_position_m.empty() && record.force_N.empty());
            if (response->size() >= 2 * half_least &&
                ((!may_repeat && is_exact(*response, how)) || is_noisy_copy(record, *response, *cause, how))) {
                throw input_error(record.path + ": its second half is its first one" +
                                  (how.is_mirrored ? " backwards" : " again") +
                                  ": held-out data that is no independent evidence; give a record that was "
                                  "measured in one go");
            }
        }
    }
    refuse_noise_of_first_half(record);
}

void refuse_same(const std::vector<input_file> &inputs)
{
    for (std::size_t i = 0; i < inputs.size(); i++) {
        for (std::size_t k = 0; k < i; k++) {
            if (inputs[i].content == inputs[k].content) {
                throw input_error(inputs[i].path + ": has the same content as " + inputs[k].path +
                                  ": held-out data that is no independent evidence; give another measurement");
            }
        }
    }
}

void refuse_derived(const record &other, const record &original)
{
    const std::vector<measured_column> columns = measured_columns(original, other);
    const auto copy =
        find_copy(rows_of(original, columns, 0, original.size()), rows_of(other, columns, 0, other.size()));
    if (copy) {
        const double begin_s = original.period_s * static_cast<double>(copy->begin);
        throw input_error(other.path + ": " + columns[copy->column].name + " has the noise of " + original.path +
                          words_of(*copy) + (copy->begin != 0 ? formatted(", from its %.6g s on", begin_s) : "") +
                          ": held-out data that is no independent evidence; give another measurement");
    }
}

} // namespace berth
