#include "side_records.h"

#include <algorithm>
#include <cmath>

#include "../../../hal/rig/rig_file.h"
#include "../formatted.h"
#include "../noise/floor.h"
#include "../noise/lattice_step.h"

namespace berth
{

namespace
{

const std::vector<double> &output_of(const record &record, block block)
{
    return block == block::manipulator ? record.command_position_m
           : block == block::robot     ? record.robot_position_m
                                       : record.force_N;
}

/* Of a signal in steps so coarse that what its noise looks like depends on where between two steps it rests: a
 * rounded normal noise has the variance sigma^2 + q^2/12 within 3 % from sigma = q/2 on (Widrow & Kollar 2008), and
 * that is what it has in motion. */
bool is_hidden_by_steps(const noise_model &noise, const std::vector<double> &signal)
{
    constexpr double least = 0.58; /* rms over step, at sigma = q/2 */
    return noise.rms < least * lattice_step(signal);
}

/* To `share` of the largest one, over the rows that both have. */
bool is_same(const std::vector<double> &a, const std::vector<double> &b, double share)
{
    double largest = 0.0;
    double difference = 0.0;
    for (std::size_t n = 0; n < std::min(a.size(), b.size()); n++) {
        largest = std::max(largest, std::abs(a[n]));
        difference = std::max(difference, std::abs(a[n] - b[n]));
    }
    return difference <= share * largest;
}

constexpr double rounding = 1e-6;

bool is_nothing(const std::vector<double> &x)
{
    return std::all_of(x.begin(), x.end(), [](double value) { return value == 0.0; });
}

/* What the operator does, in all that both records tell of it; where they tell nothing, or that he does nothing,
 * what comes of it: in a closed loop the force's noise moves the command. */
bool is_repeated(const record &data, const record &other)
{
    constexpr double about = 0.05;
    bool is_told = false;
    for (const auto signal : {&record::operator_force_N, &record::operator_position_m}) {
        const std::vector<double> &a = data.*signal;
        const std::vector<double> &b = other.*signal;
        if (a.empty() || b.empty() || (is_nothing(a) && is_nothing(b))) {
            continue;
        }
        if (!is_same(a, b, rounding)) {
            return false;
        }
        is_told = true;
    }
    return is_told || is_same(data.command_position_m, other.command_position_m, about);
}

/* Both have it, or neither. */
bool have_alike(const std::vector<double> &a, const std::vector<double> &b)
{
    return a.empty() == b.empty();
}

/* Measured less simulated. */
std::vector<double> error_of(const record &record, block block, const rig &rig)
{
    const sample_events none;
    block_model model(block, record, rig, none, held_out_parts::none);
    std::vector<double> error;
    model.error(rig, error);
    return error;
}

} // namespace

std::optional<noise_model> standstill_floor(const record &record, block block)
{
    const std::vector<double> &x = output_of(record, block);
    if (x.empty()) {
        return {};
    }
    std::vector<double> noise(x.size(), 0.0);
    std::vector<row_use> uses(x.size(), row_use::fit);
    for (const record_segment &part : record.segments) {
        const double count = static_cast<double>(part.end - part.begin);
        double mean = 0.0;
        double slope = 0.0;
        double square = 0.0;
        for (std::size_t n = part.begin; n < part.end; n++) {
            mean += x[n] / count;
        }
        for (std::size_t n = part.begin; n < part.end; n++) {
            const double at = static_cast<double>(n - part.begin) - 0.5 * (count - 1.0);
            slope += at * (x[n] - mean);
            square += at * at;
        }
        for (std::size_t n = part.begin; n < part.end; n++) {
            const double at = static_cast<double>(n - part.begin) - 0.5 * (count - 1.0);
            noise[n] = x[n] - mean - at * (square > 0.0 ? slope / square : 0.0);
        }
        uses[part.begin] = row_use::none;
    }
    const noise_model found = estimate_noise(noise, uses, 8, colour_of(block));
    return is_hidden_by_steps(found, x) ? std::nullopt : std::optional(at_least(found, resolution_rms(block)));
}

bool have_same_columns(const record &first, const record &second, block block)
{
    return can_replay(first, block) && can_replay(second, block) &&
           (block != block::manipulator || (have_alike(first.operator_force_N, second.operator_force_N) &&
                                            have_alike(first.operator_position_m, second.operator_position_m) &&
                                            have_alike(first.force_N, second.force_N)));
}

bool go_the_same_way(const record &first, const record &second, block block)
{
    if (block != block::manipulator) {
        return !first.command_position_m.empty() && !second.command_position_m.empty() &&
               is_same(first.command_position_m, second.command_position_m, rounding);
    }
    return is_same(first.operator_force_N, second.operator_force_N, rounding) &&
           is_same(first.operator_position_m, second.operator_position_m, rounding) &&
           is_same(first.force_N, second.force_N, rounding);
}

std::optional<noise_model> repetition_floor(const record &first, const record &second, block block, const rig &rig)
{
    if (!have_same_columns(first, second, block)) {
        return {};
    }
    const bool is_same_way = go_the_same_way(first, second, block);
    const std::vector<double> a = is_same_way ? output_of(first, block) : error_of(first, block, rig);
    const std::vector<double> b = is_same_way ? output_of(second, block) : error_of(second, block, rig);
    const std::size_t size = std::min(a.size(), b.size());
    std::vector<double> noise(size);
    for (std::size_t n = 0; n < size; n++) {
        noise[n] = (a[n] - b[n]) / std::sqrt(2.0);
    }
    const noise_model found = estimate_noise(noise, std::vector<row_use>(size, row_use::fit), 8, colour_of(block));
    return is_hidden_by_steps(found, output_of(first, block))
               ? std::nullopt
               : std::optional(at_least(found, resolution_rms(block)));
}

void refuse_useless(const record &other, const std::string &role, const record &data)
{
    const auto range = [](const std::vector<double> &x) {
        const auto [least, most] = std::minmax_element(x.begin(), x.end());
        return x.empty() ? 0.0 : *most - *least;
    };
    const bool any = [&] {
        for (const block block : {block::manipulator, block::robot, block::force}) {
            if (role == "--validate" ? can_replay(data, block) && can_replay(other, block)
                                     : can_replay(data, block) && !output_of(other, block).empty()) {
                return true;
            }
        }
        return false;
    }();
    if (!any) {
        throw input_error(other.path + ": " + role + " has no block in common with " + data.path +
                          ": it needs the same columns");
    }
    constexpr double at_rest = 0.01; /* of the record's own way */
    if (role == "--standstill" && range(other.command_position_m) > at_rest * range(data.command_position_m)) {
        throw input_error(other.path + ": is no standstill: its command goes " +
                          formatted("%.3g m", range(other.command_position_m)) +
                          "; record it while the command stays where it is");
    }
    if (role == "--repeat" && !is_repeated(data, other)) {
        throw input_error(
            other.path + ": repeats no command of " + data.path +
            ": the two differ; use it as --validate, or repeat the run with the same operator command");
    }
}

} // namespace berth
