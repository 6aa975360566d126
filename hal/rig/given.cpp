#include "given.h"

#include <algorithm>

#include "given_file.h"
#include "keys.h"
#include "rig_file.h"

namespace berth
{

namespace
{

std::string_view section_of(std::string_view path)
{
    return path.substr(0, path.find('.'));
}

std::size_t index_of(const rig_key &key)
{
    return static_cast<std::size_t>(&key - rig_keys().data());
}

/* Effects that are not there are no assumption about the rig, and what is wired to real lines is not asked here. */
bool can_be_assumed(const rig_key &key)
{
    return key.own_member != nullptr && section_of(key.path) != "target";
}

bool names(std::string_view name, const rig_key &key)
{
    return name == key.path || name == section_of(key.path);
}

/* False: no key and no section has this name. */
bool forget(rig &rig, std::string_view name)
{
    bool is_known = false;
    for (const rig_key &key : rig_keys()) {
        if (names(name, key)) {
            rig.given.reset(index_of(key));
            is_known = true;
        }
    }
    return is_known;
}

} // namespace

void set_given(rig &rig, std::string_view path, bool is_given)
{
    if (const rig_key *const key = find_key(path)) {
        rig.given.set(index_of(*key), is_given);
    }
}

bool is_given(const rig &rig, std::string_view path)
{
    const rig_key *const key = find_key(path);
    return key != nullptr && rig.given.test(index_of(*key));
}

bool states_section(const rig &rig, std::string_view section)
{
    return std::any_of(rig_keys().begin(), rig_keys().end(), [&](const rig_key &key) {
        return section_of(key.path) == section && rig.given.test(index_of(key));
    });
}

std::string_view given_mark(const rig &rig, std::string_view path)
{
    const rig_key *const key = find_key(path);
    if (key == nullptr || !can_be_assumed(*key)) {
        return "";
    }
    return rig.given.test(index_of(*key)) ? "given: " : "assumed: ";
}

void note_given(rig &rig, const key_places &places)
{
    for (const auto &[path, where] : places) {
        set_given(rig, path, true);
    }
}

std::vector<std::string> read_assumed(const toml::node &node, const std::string &where)
{
    const toml::array *const list = node.as_array();
    std::vector<std::string> found;
    for (std::size_t i = 0; list != nullptr && i < list->size(); i++) {
        const std::string name = list->get(i)->value_or(std::string());
        if (std::none_of(rig_keys().begin(), rig_keys().end(),
                         [&](const rig_key &key) { return names(name, key); })) {
            fail(where, {"assumed", "must name sections and keys of a rig (is " + text_of(*list->get(i)) + ")"});
        }
        found.push_back(name);
    }
    if (list == nullptr) {
        fail(where, {"assumed", "must be a list of sections and keys, as [\"limits\"]: their values count as not "
                                "stated; leave it out where all are stated"});
    }
    return found;
}

std::vector<std::string> assumed_names(const rig &rig)
{
    std::vector<std::string> found;
    const std::vector<rig_key> &keys = rig_keys();
    for (auto first = keys.begin(); first != keys.end();) {
        const std::string_view section = section_of(first->path);
        const auto end =
            std::find_if(first, keys.end(), [&](const rig_key &key) { return section_of(key.path) != section; });
        const auto is_stated = [&](const rig_key &key) { return rig.given.test(index_of(key)); };
        const bool is_whole = std::none_of(first, end, is_stated);
        for (auto key = first; key != end; ++key) {
            if (can_be_assumed(*key) && !is_stated(*key) && (!is_whole || key == first)) {
                found.emplace_back(is_whole ? section : key->path);
            }
        }
        first = end;
    }
    return found;
}

std::string assumed_text(const rig &rig)
{
    std::string text;
    for (const std::string &name : assumed_names(rig)) {
        text += (text.empty() ? "" : ",") + name;
    }
    return text;
}

bool set_assumed(rig &rig, std::string_view text)
{
    bool are_known = true;
    while (!text.empty()) {
        const std::string_view name = text.substr(0, text.find(','));
        are_known = forget(rig, name) && are_known;
        text.remove_prefix(std::min(text.size(), name.size() + 1));
    }
    return are_known;
}

bool is_robot_alone(const rig &rig)
{
    const bool has_object = is_given(rig, "object.kind") || is_given(rig, "object.mass_kg");
    return is_given(rig, "robot.dead_time_ms") && !is_given(rig, "manipulator.mass_kg") && !has_object;
}

void refuse_unstated(const rig &rig, const std::string &origin)
{
    const bool has_object = is_given(rig, "object.kind") || is_given(rig, "object.mass_kg");
    const bool touches_nothing = rig.object.kind == object_kind::none;
    const bool is_beam = rig.object.kind == object_kind::beam; /* its mass follows from keys that must be there */
    const struct {
        bool is_missing;
        const char *key;
        const char *what;
        const char *remedy;
    } decisive[] = {
        {!has_object, "object", "the section [object] is missing",
         "state it, or object.kind = \"none\" for a robot that touches nothing"},
        {!touches_nothing && !is_beam && !is_given(rig, "object.mass_kg"), "object.mass_kg", "is missing",
         "state the mass of the object"},
        {!is_given(rig, "manipulator.mass_kg"), "manipulator.mass_kg", "is missing",
         "state mass, stiffness and damping of the simulated manipulator in [manipulator]"},
        {!is_given(rig, "robot.dead_time_ms"), "robot.dead_time_ms", "is missing",
         "state the time from command to motion, or name a preset with --robot (see `berth robots`)"},
    };
    for (const auto &one : decisive) {
        if (one.is_missing) {
            throw input_error(origin, one.key,
                              std::string(one.what) + ", and without it berth has no answer: " + one.remedy +
                                  "; base = \"ess\" takes all that is left out from the reference case on purpose");
        }
    }
}

} // namespace berth
