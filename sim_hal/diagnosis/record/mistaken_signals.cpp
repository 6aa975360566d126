#include "mistaken_signals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../../../hal/rig/rig_file.h"
#include "../formatted.h"
#include "../replay/block_model.h"
#include "about_mean.h"
#include "record_columns.h"
#include "written_digits.h"

namespace berth
{

namespace
{

struct mistake {
    std::string_view signal;
    double scale; /* that would put it right */
    std::string_view what;
    double error = unlimited; /* that is left with it, of the output's own size */
    bool is_sure = false;
};

constexpr double N_per_kgf = 9.80665;
constexpr double N_per_lbf = 4.4482216152605;
constexpr mistake mistakes_of_force[] = {{"force_N", -1.0, "had the opposite sign"},
                                         {"force_N", 1e3, "were in kN"},
                                         {"force_N", 1e-3, "were in mN"},
                                         {"force_N", N_per_kgf, "were in kgf"},
                                         {"force_N", N_per_lbf, "were in lbf"}};
constexpr mistake mistakes_of_command[] = {{"command_position_m", 1e-3, "were in mm"},
                                           {"command_position_m", 1e-2, "were in cm"},
                                           {"command_position_m", 0.0254, "were in inches"}};
constexpr mistake mistakes_of_robot[] = {{"robot_position_m", -1.0, "had the opposite sign"},
                                         {"robot_position_m", 1e-3, "were in mm"},
                                         {"robot_position_m", 1e-2, "were in cm"},
                                         {"robot_position_m", 0.0254, "were in inches"}};
constexpr mistake mistakes_of_operator[] = {{"operator_force_N", -1.0, "had the opposite sign"},
                                            {"operator_force_N", 1e3, "were in kN"},
                                            {"operator_force_N", 1e-3, "were in mN"},
                                            {"operator_force_N", N_per_kgf, "were in kgf"},
                                            {"operator_force_N", N_per_lbf, "were in lbf"},
                                            {"operator_position_m", -1.0, "had the opposite sign"},
                                            {"operator_position_m", 1e-3, "were in mm"}};

std::vector<mistake> mistakes_in(block block)
{
    std::vector<mistake> all;
    const auto add = [&](const auto &more) { all.insert(all.end(), std::begin(more), std::end(more)); };
    if (block == block::robot) {
        add(mistakes_of_robot);
    } else {
        add(mistakes_of_force);
    }
    if (block == block::manipulator) {
        add(mistakes_of_operator);
    }
    add(mistakes_of_command);
    return all;
}

std::vector<double> *member_of(record &data, std::string_view signal)
{
    for (const signal_member &known : signal_members) {
        if (known.name == signal) {
            return &(data.*known.member);
        }
    }
    return nullptr;
}

/* And what was derived from it. */
void scale_signal(record &data, const mistake &one)
{
    const auto scale = [&](std::vector<double> &values) {
        std::transform(values.begin(), values.end(), values.begin(), [&](double x) { return one.scale * x; });
    };
    scale(*member_of(data, one.signal));
    if (data.is_velocity_derived && one.signal == "operator_position_m") {
        scale(data.operator_velocity_m_per_s);
    }
}

/* rms of what the rig as given does not explain, of that of the output about its mean. */
double share_unexplained(block block, const record &data, const rig &given)
{
    const sample_events none;
    block_model model(block, data, given, none, held_out_parts::none);
    std::vector<double> error;
    model.error(given, error);
    const double moves = rms_about_mean(model);
    return moves > 0.0 ? rms_of(error, model.uses(), row_use::fit) / moves : 0.0;
}

/* A force that hardly acts may be one that something else holds against; a stiffness of a tenth is a rig file that
 * is wrong, one of a thousandth is none. */
bool may_be_the_rig(block block, const mistake &one)
{
    if (one.signal != "force_N" || one.scale < 0.0) {
        return false;
    }
    return block == block::manipulator ? one.scale < 1.0 : one.scale > 0.03 && one.scale < 30.0;
}

/* Those after which far less is left, the best one first. */
std::vector<mistake> find_mistakes(block block, const record &data, const rig &given)
{
    constexpr double is_far = 0.5; /* a rig file that is only wrong leaves less, a sign 2, a factor 1 or 1000 */
    constexpr double far_less = 0.3;
    /* Only where next to nothing is right as it stands, and nearly all is with it, a rig file cannot be that wrong.
     */
    constexpr double is_wrong = 0.9;
    constexpr double is_right = 0.1;
    const double before = share_unexplained(block, data, given);
    /* A manipulator starts anew again and again from what was measured: its errors are small in any case. */
    if (!(before > (block == block::manipulator ? 0.0 : is_far))) {
        return {};
    }
    std::vector<mistake> found;
    record changed = data;
    for (mistake &one : std::vector<mistake>(mistakes_in(block))) {
        std::vector<double> &values = *member_of(changed, one.signal);
        const std::vector<double> original = values;
        if (values.empty()) {
            continue;
        }
        scale_signal(changed, one);
        one.error = share_unexplained(block, changed, given);
        values = original;
        changed.operator_velocity_m_per_s = data.operator_velocity_m_per_s;
        const bool may_be_rig = may_be_the_rig(block, one);
        if (one.error < (may_be_rig ? is_right : is_far) && one.error < far_less * before) {
            one.is_sure =
                !may_be_rig && (block == block::manipulator || before > is_wrong) && one.error < is_right * before;
            found.push_back(one);
        }
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const mistake &a, const mistake &b) { return a.error < b.error; });
    return found;
}

std::string mapping_of(const mistake &one, const rig &given)
{
    signal_source source = source_of(given, one.signal);
    source.scale *= one.scale;
    source.offset *= one.scale;
    return mapping_of(source);
}

bool is_mapped(const rig &given, std::string_view signal)
{
    return std::any_of(given.signals.begin(), given.signals.end(),
                       [&](const signal_source &source) { return source.signal == signal; });
}

/* Of the last digit that was written. */
double largest_unit(const std::vector<double> &values)
{
    const std::vector<double> units = units_of_last_digits(values);
    return units.empty() ? 0.0 : *std::max_element(units.begin(), units.end());
}

/* A controller that sends back the setpoint in the place of the measured position. */
bool is_echo(const record &data, const rig &given)
{
    const std::vector<double> &command = data.command_position_m;
    const std::vector<double> &robot = data.robot_position_m;
    if (!can_replay(data, block::robot) || 1e-3 * given.robot.dead_time_ms < data.period_s) {
        return false;
    }
    const auto [least, largest] = std::minmax_element(command.begin(), command.end());
    const double way_m = *largest - *least;
    const double same_m = 1e-9 * way_m + std::min(1e-6 * way_m, largest_unit(robot) + largest_unit(command));
    double rows = 0.0;
    for (std::size_t n = 0; n < command.size(); n++) {
        rows += std::abs(robot[n] - command[n]) <= same_m ? 1.0 : 0.0;
    }
    return rows > 0.99 * static_cast<double>(command.size());
}

/* The one that is said to be the robot's runs ahead, and with the two exchanged next to nothing is left. */
bool are_exchanged(const record &data, const rig &given)
{
    constexpr double nothing = 0.1;
    constexpr double something = 0.02;
    if (!can_replay(data, block::robot)) {
        return false;
    }
    const double before = share_unexplained(block::robot, data, given);
    if (before < something) {
        return false;
    }
    record exchanged = data;
    std::swap(exchanged.command_position_m, exchanged.robot_position_m);
    return share_unexplained(block::robot, exchanged, given) < nothing * std::min(1.0, before);
}

void refuse_exchanged_positions(record &data, const rig &given)
{
    if (!are_exchanged(data, given)) {
        return;
    }
    const std::string command = source_of(given, "command_position_m").column;
    const std::string robot = source_of(given, "robot_position_m").column;
    const std::string words = "the columns of command_position_m and robot_position_m look exchanged: the robot "
                              "would be ahead of its commands; say in the rig file [signals] command_position_m = { "
                              "column = \"" +
                              robot + "\" } and robot_position_m = { column = \"" + command + "\" }";
    if (is_mapped(given, "command_position_m") || is_mapped(given, "robot_position_m")) {
        data.notes.push_back(words);
        return;
    }
    throw input_error(data.path + ":" + std::to_string(data.header_line) + ": " + words +
                      "; or map each to its own, if it is right as it is");
}

/* The robot's reports count from another zero than the commands: what is left is the same throughout, and not in
 * proportion to the position, as with another gain. */
void tell_other_zero(record &data, const rig &given)
{
    constexpr double nearly_all = 0.9; /* of the error's square */
    if (!can_replay(data, block::robot)) {
        return;
    }
    const sample_events none;
    block_model model(block::robot, data, given, none, held_out_parts::none);
    std::vector<double> error;
    model.error(given, error);
    double rows = 0.0;
    double sum = 0.0;
    double square = 0.0;
    double along = 0.0;
    double position_square = 0.0;
    for (std::size_t n = 0; n < error.size(); n++) {
        if (model.uses()[n] == row_use::fit) {
            const double x = data.command_position_m[n];
            rows += 1.0;
            sum += error[n];
            square += error[n] * error[n];
            along += error[n] * x;
            position_square += x * x;
        }
    }
    const double by_zero = sum * sum / std::max(rows, 1.0);
    const double by_gain = along * along / std::max(position_square, 1e-300);
    if (square - by_zero > (1.0 - nearly_all) * square || square - by_zero > 0.5 * (square - by_gain)) {
        return;
    }
    signal_source source = source_of(given, "robot_position_m");
    source.offset -= sum / rows;
    data.notes.push_back(formatted("robot_position_m differs by %.4g m throughout, ", sum / rows) +
                         "as if it counted from another zero: say in the rig file " + mapping_of(source));
}

/* The manipulator is moved by the newest force that has arrived when its command is computed. Stamped when it was
 * sampled, or logged after the tick, a force that fits it stands a row before or behind. */
void tell_shifted_force(record &data, const rig &given)
{
    constexpr double nearly_nothing = 0.1; /* of what the rows as they are leave */
    if (data.force_N.empty() || !can_replay(data, block::manipulator)) {
        return;
    }
    const double as_it_is = share_unexplained(block::manipulator, data, given);
    for (const std::ptrdiff_t rows : {1, -1}) {
        record shifted = data;
        for (const record_segment &part : data.segments) {
            for (std::size_t n = part.begin + 1; n + 1 < part.end; n++) {
                shifted.force_N[n] = data.force_N[static_cast<std::size_t>(static_cast<std::ptrdiff_t>(n) - rows)];
            }
        }
        if (share_unexplained(block::manipulator, shifted, given) < nearly_nothing * as_it_is) {
            data.notes.push_back(std::string("force_N stands one row ") + (rows > 0 ? "before" : "behind") +
                                 " the one in which it moves the manipulator: a row has the newest force that had "
                                 "arrived when its command was computed; move it there, or the manipulator and the "
                                 "delay of the sensor come out wrong");
            return;
        }
    }
}

} // namespace

void refuse_mistaken_signals(record &data, const rig &given)
{
    if (data.header_line == 0) {
        return; /* a log has its own signs and units */
    }
    refuse_exchanged_positions(data, given);
    if (is_echo(data, given)) {
        throw input_error(data.path + ":" + std::to_string(data.header_line) +
                          ": robot_position_m repeats command_position_m, although the rig's robot has a dead time: "
                          "an echoed setpoint is no measured position; name the column of the measured one in "
                          "[signals], or leave it out");
    }
    for (const block block : {block::manipulator, block::robot, block::force}) {
        if (!can_replay(data, block)) {
            continue;
        }
        const std::vector<mistake> found = find_mistakes(block, data, given);
        if (found.empty()) {
            continue;
        }
        const mistake &best = found.front();
        const std::string name(best.signal);
        std::string words = name + " looks as if it " + std::string(best.what);
        std::string cure = mapping_of(best, given);
        for (const mistake &other : found) {
            if (other.signal != best.signal && other.error < 1.1 * best.error + 1e-3) {
                words += ", or " + std::string(other.signal) + " as if it " + std::string(other.what);
                cure += " or " + mapping_of(other, given);
                break;
            }
        }
        words += ": say in the rig file " + cure;
        if (is_mapped(given, best.signal) || !best.is_sure) {
            data.notes.push_back(words);
            continue;
        }
        throw input_error(data.path + ":" + std::to_string(data.header_line) + ": " + words +
                          "; or scale = 1, if it is right as it is");
    }
    tell_other_zero(data, given);
    tell_shifted_force(data, given);
}

} // namespace berth
