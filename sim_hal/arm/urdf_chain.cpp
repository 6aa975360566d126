#include "urdf_chain.h"

#include <algorithm>
#include <map>

#include "../../firmware/arm/arm_config.h"
#include "../../hal/rig/toml_file.h"

namespace berth
{

namespace
{

constexpr std::size_t mimic_steps_max = 100; /* a joint that follows one that follows one ... */

bool can_move(urdf_motion motion)
{
    return motion == urdf_motion::revolute || motion == urdf_motion::continuous;
}

const urdf_hold *hold_of(const urdf_choice &choice, const urdf_joint &joint)
{
    const auto found = std::find_if(choice.holds.begin(), choice.holds.end(),
                                    [&](const urdf_hold &hold) { return hold.joint == joint.name; });
    return found == choice.holds.end() ? nullptr : &*found;
}

/* For each joint, whether a link of mass hangs on it, however far out. */
std::vector<bool> joints_with_mass(const urdf_model &model)
{
    const std::vector<urdf_joint> &joints = model.joints();
    std::vector<bool> have(joints.size(), false);
    for (std::size_t i = joints.size(); i-- > 0;) { /* outermost first */
        const urdf_body link = model.body_of(joints[i].child);
        have[i] = have[i] || link.mass_kg > 0.0 || !link.inertia_kg_m2.isZero(0.0);
        if (const urdf_joint *const before = model.joint_to(joints[i].parent); before != nullptr && have[i]) {
            have[static_cast<std::size_t>(before - joints.data())] = true;
        }
    }
    return have;
}

/* For each joint, whether it can be one of the arm's. */
std::vector<bool> movable_joints(const urdf_model &model, const urdf_choice &choice)
{
    std::vector<bool> movable = joints_with_mass(model);
    for (std::size_t i = 0; i < movable.size(); i++) {
        const urdf_joint &joint = model.joints()[i];
        movable[i] = movable[i] && can_move(joint.motion) && !joint.mimic && hold_of(choice, joint) == nullptr;
    }
    return movable;
}

void check_holds(const urdf_model &model, const urdf_choice &choice)
{
    for (const urdf_hold &hold : choice.holds) {
        const urdf_joint *const joint = model.joint_named(hold.joint);
        const auto fail = [&](const std::string &message) {
            const std::string what = "--hold " + hold.joint + ": ";
            joint == nullptr ? model.fail(what + message) : model.fail(joint->xml, what + message);
        };
        if (joint == nullptr) {
            std::string names;
            for (const urdf_joint &known : model.joints()) {
                if (known.motion != urdf_motion::fixed) {
                    names += (names.empty() ? "" : ", ") + known.name;
                }
            }
            fail("there is no such joint; there are " + names);
        }
        if (joint->motion == urdf_motion::fixed) {
            fail("the joint is fixed as it is");
        }
        if (joint->mimic) {
            fail("the joint follows \"" + joint->mimic->joint + "\"; hold that one");
        }
        if (!hold.value) {
            continue;
        }
        if (joint->motion == urdf_motion::planar || joint->motion == urdf_motion::floating) {
            fail("such a joint is held at its origin only; leave the value out");
        }
        const urdf_range range = model.range_of(*joint);
        if (range.is_stated && range.upper > range.lower &&
            !(*hold.value >= range.lower && *hold.value <= range.upper)) {
            fail(number_text(*hold.value) + " is outside its range, " + number_text(range.lower) + " to " +
                 number_text(range.upper) + (joint->motion == urdf_motion::prismatic ? " m" : " rad"));
        }
    }
}

/* A way from where a tree begins. */
struct way {
    std::size_t movable = 0;
    std::size_t links = 0;
    bool is_past_held = false; /* behind the last joint that moves, one is held: a finger is no arm's end */

    bool is_longer(const way &other) const
    {
        return movable != other.movable ? movable > other.movable : links > other.links;
    }
};

/* The end of the longest movable chain of those that begin at `base` or, where that is empty, anywhere. */
std::string end_of_longest(const urdf_model &model, const std::vector<bool> &movable, const std::string &base)
{
    std::map<std::string, way> ways;
    std::string end = base.empty() ? model.root() : base;
    ways[end] = {};
    way longest;
    for (std::size_t i = 0; i < movable.size(); i++) {
        const urdf_joint &joint = model.joints()[i];
        const auto parent = ways.find(joint.parent);
        if (joint.motion == urdf_motion::floating && base.empty()) {
            ways[joint.child] = {};
        } else if (parent != ways.end() && joint.motion != urdf_motion::floating) {
            const bool does_move = movable[i];
            const bool is_held = !does_move && joint.motion != urdf_motion::fixed;
            ways[joint.child] = {parent->second.movable + (does_move ? 1 : 0), parent->second.links + 1,
                                 !does_move && (parent->second.is_past_held || is_held)};
        } else {
            continue;
        }
        if (!ways[joint.child].is_past_held && ways[joint.child].is_longer(longest)) {
            longest = ways[joint.child];
            end = joint.child;
        }
    }
    return end;
}

/* The joints from `base`, or from where the tree begins if that is empty, to `tool`. */
std::vector<const urdf_joint *> way_to(const urdf_model &model, const std::string &base, const std::string &tool)
{
    std::vector<const urdf_joint *> way;
    for (std::string at = tool; at != base;) {
        const urdf_joint *const joint = model.joint_to(at);
        if (joint == nullptr || joint->motion == urdf_motion::floating) {
            if (base.empty()) {
                break;
            }
            std::string said = "link \"" + tool;
            said += "\" does not hang on link \"";
            said += base;
            said += joint == nullptr ? "\"" : "\": joint \"" + joint->name + "\" between them floats";
            model.fail(said);
        }
        way.push_back(joint);
        at = joint->parent;
    }
    std::reverse(way.begin(), way.end());
    return way;
}

void refuse_unknown(const urdf_model &model, const std::string &link, const char *option)
{
    if (!link.empty() && !model.has_link(link)) {
        model.fail("there is no link \"" + link + "\" for " + option);
    }
}

[[noreturn]] void fail_unmoved(const urdf_model &model, const urdf_chain &chain)
{
    const std::vector<bool> have_mass = joints_with_mass(model);
    bool any_turns = false;
    bool any_has_mass = false;
    for (std::size_t i = 0; i < have_mass.size(); i++) {
        any_turns = any_turns || can_move(model.joints()[i].motion);
        any_has_mass = any_has_mass || (can_move(model.joints()[i].motion) && have_mass[i]);
    }
    model.fail("no joint moves between link \"" + chain.base + "\" and link \"" + chain.tool + "\"; " +
               (!any_turns ? "an arm needs one that is revolute or continuous; a rigid satellite is no arm but the "
                             "manipulator of a rig file"
                : !any_has_mass ? "what its joints turn has no mass: state <inertial> of the links"
                                : "choose others with --base and --tool, or hold fewer joints"));
}

} // namespace

urdf_chain choose_chain(const urdf_model &model, const urdf_choice &choice)
{
    refuse_unknown(model, choice.base, "--base");
    refuse_unknown(model, choice.tool, "--tool");
    check_holds(model, choice);
    const bool tool_is_free = choice.tool.empty();
    urdf_chain chain = {};
    const std::vector<bool> movable = movable_joints(model, choice);
    chain.tool = tool_is_free ? end_of_longest(model, movable, choice.base) : choice.tool;
    const std::vector<const urdf_joint *> way = way_to(model, choice.base, chain.tool);
    chain.base = way.empty() ? chain.tool : way.front()->parent;
    const urdf_joint *const to_base = model.joint_to(chain.base);
    chain.floats = to_base != nullptr && to_base->motion == urdf_motion::floating;
    for (const urdf_joint *joint : way) {
        const auto place = static_cast<std::size_t>(joint - model.joints().data());
        if (!movable[place]) {
            continue;
        }
        chain.movable++;
        if (chain.moving.size() < ARM_JOINTS_MAX) {
            chain.moving.push_back(place);
        } else if (tool_is_free && chain.movable == ARM_JOINTS_MAX + 1) {
            chain.tool = joint->parent;
        }
    }
    if (chain.moving.empty()) {
        fail_unmoved(model, chain);
    }
    return chain;
}

double resting_value(const urdf_model &model, const urdf_joint &joint, bool moves)
{
    const urdf_range range = model.range_of(joint);
    if (!range.is_stated || !(range.upper > range.lower)) {
        return 0.0;
    }
    if (moves) {
        return std::clamp(0.0, range.lower, range.upper);
    }
    return range.lower <= 0.0 && range.upper >= 0.0 ? 0.0 : 0.5 * range.lower + 0.5 * range.upper;
}

std::vector<double> held_values(const urdf_model &model, const urdf_choice &choice,
                                const std::vector<std::size_t> &moving, std::vector<std::string> &warnings)
{
    const std::vector<urdf_joint> &joints = model.joints();
    std::vector<double> values;
    for (const urdf_joint &joint : joints) {
        double scale = 1.0;
        double offset = 0.0;
        const urdf_joint *at = &joint;
        for (std::size_t steps = 0; at->mimic; steps++) {
            const urdf_element *const xml = joint.xml->FirstChildElement("mimic");
            const urdf_joint *const followed = model.joint_named(at->mimic->joint);
            if (steps == mimic_steps_max) {
                model.fail(xml, "the joints follow each other in a circle, or over more than 100");
            }
            if (followed == nullptr) {
                warnings.push_back(model.place(xml) + ": there is no joint \"" + at->mimic->joint +
                                   "\"; the joint is held as one that follows none");
                break;
            }
            offset += scale * at->mimic->offset;
            scale *= at->mimic->multiplier;
            at = followed;
        }
        const auto place = static_cast<std::size_t>(at - joints.data());
        const bool is_moving = std::find(moving.begin(), moving.end(), place) != moving.end();
        const urdf_hold *const hold = hold_of(choice, *at);
        const double value = hold != nullptr && hold->value ? *hold->value : resting_value(model, *at, is_moving);
        values.push_back(scale * value + offset);
    }
    return values;
}

} // namespace berth
