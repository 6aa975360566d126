#include "orders.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "sections.h"

namespace berth
{

namespace
{

constexpr double ordered_way_max_m = 6.5; /* of the frame */
constexpr double speed_max_m_per_s = 4.0;
constexpr double speed_step_m_per_s = 1e-3;
constexpr double way_step_m = 2e-4;
constexpr double rate_max_rad_per_s = 8.3;
constexpr double rate_step_rad_per_s = 1e-6;
constexpr double ordered_angle_max_rad = 8.3;
constexpr double at_max_s = 1e9;

/* "line_m" is a list, "joint" a whole number and "follow" true. */
constexpr std::array<section_key, 7> keys_of_order = {{
    {"at_s", "when the order is given, counted from the release", 0.0, at_max_s},
    {"line_m", "way of the tool along a line, two or three numbers in the base's axes", -ordered_way_max_m,
     ordered_way_max_m},
    {"speed_m_per_s", "speed along the line", 0.0, speed_max_m_per_s},
    {"joint", "the joint that moves, from 1 on", 1, ARM_JOINTS_MAX},
    {"move_to_rad", "angle that the joint moves to", -ordered_angle_max_rad, ordered_angle_max_rad},
    {"rate_rad_per_s", "rate of the joint; 0 stops it", -rate_max_rad_per_s, rate_max_rad_per_s},
    {"follow", "true: the tool follows the profile again"},
}};

double number(const std::string &key, const toml::node &node, const std::string &origin, double limit)
{
    const auto value = node.value<double>();
    if (!node.is_number() || !value || !(std::abs(*value) <= limit)) {
        fail(place(origin, node.source()),
             {key, "must be a number of at most " + number_text(limit) + " (is " + text_of(node) + ")"});
    }
    return *value;
}

std::int32_t read_joint(const toml::node &node, const std::string &origin)
{
    if (!node.is_integer()) {
        fail(place(origin, node.source()), {"orders.joint", "must be a whole number (is " + text_of(node) + ")"});
    }
    return static_cast<std::int32_t>(number("orders.joint", node, origin, ARM_JOINTS_MAX)) - 1;
}

bool is_multiple(double value, double step)
{
    const double steps = value / step;
    return std::abs(steps - std::round(steps)) <= 1e-6;
}

/* What would be passed over in silence. */
void check_keys(const toml::table &table, std::string_view kind, const std::string &origin)
{
    for (const auto &[name, node] : table) {
        const std::string_view key = name.str();
        const std::string_view of = key == "speed_m_per_s"                            ? "line_m"
                                    : key == "move_to_rad" || key == "rate_rad_per_s" ? "joint"
                                                                                      : kind;
        if (of != kind) {
            fail(place(origin, node.source()),
                 {"orders." + std::string(key), "goes with " + std::string(of) + " only"});
        }
    }
}

void read_way(arm_order &order, const toml::node &node, const std::string &origin)
{
    const toml::array *const way = node.as_array();
    if (way == nullptr || way->size() < 2 || way->size() > 3) {
        fail(place(origin, node.source()), {"orders.line_m", "must be two or three numbers in brackets"});
    }
    for (std::size_t i = 0; i < way->size(); i++) {
        order.way_m[i] = number("orders.line_m", *way->get(i), origin, ordered_way_max_m);
    }
    if (std::all_of(std::begin(order.way_m), std::end(order.way_m), [](double part_m) { return part_m == 0.0; })) {
        fail(place(origin, node.source()),
             {"orders.line_m", "goes nowhere; an arm that is to stand still has joint = 1 and rate_rad_per_s = 0"});
    }
    order.kind = ARM_ORDER_LINE;
}

/* Keys that make the kind first: the others only add to it. */
operator_order read_order(const toml::table &table, const std::string &origin)
{
    operator_order made{};
    arm_order &order = made.order;
    const std::string where = place(origin, table.source());
    std::string_view kind;
    int kinds = 0;
    for (const auto &[name, node] : table) {
        const std::string_view key = name.str();
        const std::string path = "orders." + std::string(key);
        if (key == "at_s") {
            made.at_s = number(path, node, origin, at_max_s);
        } else if (key == "line_m") {
            read_way(order, node, origin);
            kind = key;
            kinds++;
        } else if (key == "speed_m_per_s") {
            order.speed_m_per_s = number(path, node, origin, speed_max_m_per_s);
        } else if (key == "joint") {
            order.joint = read_joint(node, origin);
            order.kind = table.contains("move_to_rad") ? ARM_ORDER_JOINT_MOVE : ARM_ORDER_JOINT_RATE;
            kind = key;
            kinds++;
        } else if (key == "move_to_rad") {
            order.angle_rad = number(path, node, origin, ordered_angle_max_rad);
        } else if (key == "rate_rad_per_s") {
            order.rate_rad_per_s = number(path, node, origin, rate_max_rad_per_s);
        } else if (key == "follow" && node.value<bool>() == true) {
            order.kind = ARM_ORDER_FOLLOW;
            kind = key;
            kinds++;
        } else {
            fail(place(origin, node.source()),
                 {path, "unknown; there are at_s, line_m, speed_m_per_s, joint, move_to_rad, rate_rad_per_s and "
                        "follow = true"});
        }
    }
    if (kinds != 1) {
        fail(where, {"orders", "each must have one of line_m, joint and follow = true"});
    }
    check_keys(table, kind, origin);
    if (kind == "joint" && !table.contains("move_to_rad") && !table.contains("rate_rad_per_s")) {
        fail(where, {"orders.joint", "needs rate_rad_per_s or move_to_rad; rate_rad_per_s = 0 stops it"});
    }
    if (order.kind == ARM_ORDER_LINE && !(order.speed_m_per_s > 0.0)) {
        fail(where, {"orders.speed_m_per_s", "a line needs it, greater than 0"});
    }
    return made;
}

/* `last_s`: of the order before. */
std::optional<rig_error> check_order(const arm_config &arm, const operator_order &timed, double last_s)
{
    const arm_order &order = timed.order;
    const bool is_joint = order.kind == ARM_ORDER_JOINT_RATE || order.kind == ARM_ORDER_JOINT_MOVE;
    if (arm.kind == ARM_NONE) {
        return rig_error{"orders", "need an arm: manipulator.arm"};
    }
    if (!(timed.at_s > 0.0 && timed.at_s >= last_s)) {
        return rig_error{"orders.at_s", "counts from run.release_s, when the loop begins to run: it must be greater "
                                        "than 0 and not earlier than the order before"};
    }
    if (is_joint && (order.joint < 0 || order.joint >= arm.joint_count)) {
        return rig_error{"orders.joint", "must be from 1 to " + std::to_string(arm.joint_count)};
    }
    if (order.kind == ARM_ORDER_JOINT_MOVE) {
        const arm_joint &joint = arm.joints[order.joint];
        if (order.angle_rad < joint.angle_min_rad || order.angle_rad > joint.angle_max_rad) {
            return rig_error{"orders.move_to_rad", "must be an angle that joint " + std::to_string(order.joint + 1) +
                                                       " can have, from " + number_text(joint.angle_min_rad) +
                                                       " to " + number_text(joint.angle_max_rad) + " rad (is " +
                                                       number_text(order.angle_rad) + ")"};
        }
        if (order.rate_rad_per_s < 0.0) {
            return rig_error{"orders.rate_rad_per_s", "of a move must be 0 (as fast as it may) or more"};
        }
    }
    if (is_joint && !is_multiple(order.rate_rad_per_s, rate_step_rad_per_s)) {
        return rig_error{"orders.rate_rad_per_s",
                         "goes over the wire in steps of 0.000001 rad/s and must be a multiple of that"};
    }
    if (order.kind != ARM_ORDER_LINE) {
        return {};
    }
    if (!is_multiple(order.speed_m_per_s, speed_step_m_per_s)) {
        return rig_error{"orders.speed_m_per_s",
                         "goes over the wire in steps of 0.001 m/s and must be a multiple of that"};
    }
    if (arm.kind == ARM_PLANAR && order.way_m[2] != 0.0) {
        return rig_error{"orders.line_m", "must have two numbers: the arm is planar"};
    }
    for (const double part_m : order.way_m) {
        if (!is_multiple(part_m, way_step_m)) {
            return rig_error{"orders.line_m", "goes over the wire in steps of 0.0002 m and must be a multiple of "
                                              "that (is " +
                                                  number_text(part_m) + ")"};
        }
    }
    return {};
}

} // namespace

void read_orders(rig &rig, const toml::node &node, const std::string &origin, key_places &places)
{
    const toml::array *const orders = node.as_array();
    if (orders == nullptr) {
        fail(place(origin, node.source()), {"orders", "must be sections [[orders]]"});
    }
    for (const toml::node &order : *orders) {
        if (order.as_table() == nullptr) {
            fail(place(origin, order.source()), {"orders", "must be sections [[orders]]"});
        }
        rig.orders.push_back(read_order(*order.as_table(), origin));
        places[place_key_of_order(rig.orders.size())] = place(origin, order.source());
    }
}

void print_orders(const rig &rig, std::ostream &text)
{
    for (const operator_order &timed : rig.orders) {
        const arm_order &order = timed.order;
        text << "\n[[orders]]\nat_s = " << number_text(timed.at_s) << "\n";
        switch (order.kind) {
        case ARM_ORDER_LINE:
            text << "line_m = [" << number_text(order.way_m[0]) << ", " << number_text(order.way_m[1]) << ", "
                 << number_text(order.way_m[2]) << "]\nspeed_m_per_s = " << number_text(order.speed_m_per_s) << "\n";
            break;
        case ARM_ORDER_FOLLOW:
            text << "follow = true\n";
            break;
        default:
            text << "joint = " << order.joint + 1 << "\n";
            if (order.kind == ARM_ORDER_JOINT_MOVE) {
                text << "move_to_rad = " << number_text(order.angle_rad) << "\n";
            }
            text << "rate_rad_per_s = " << number_text(order.rate_rad_per_s) << "\n";
            break;
        }
    }
}

std::vector<section_key> order_keys()
{
    return {keys_of_order.begin(), keys_of_order.end()};
}

std::string place_key_of_order(std::size_t number)
{
    return "orders." + std::to_string(number);
}

std::optional<rig_error> check_orders(const rig &rig)
{
    double last_s = 0.0;
    for (std::size_t i = 0; i < rig.orders.size(); i++) {
        if (auto error = check_order(rig.firmware.arm, rig.orders[i], last_s)) {
            error->order = i + 1;
            return error;
        }
        last_s = rig.orders[i].at_s;
    }
    return {};
}

} // namespace berth
