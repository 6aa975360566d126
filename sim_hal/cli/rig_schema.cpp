#include "rig_schema.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "../../hal/rig/arm_keys.h"
#include "../../hal/rig/keys.h"
#include "../../hal/rig/names.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/sections.h"
#include "../../hal/rig/units.h"

namespace berth
{

namespace
{

using ordered = nlohmann::ordered_json;

/* TOML's inf is no JSON. */
ordered default_of(const rig_key &key)
{
    const std::string text = value_text(rig(), key);
    return text == "inf" ? ordered() : ordered::parse(text);
}

void add_unit(ordered &schema, std::string_view name)
{
    if (const std::string unit = unit_text(name); !unit.empty()) {
        schema["unit"] = unit;
    }
}

ordered described(std::string_view meaning, const char *type)
{
    return {{"description", meaning}, {"type", type}};
}

/* A section: what it does not list is refused. */
ordered section_of(ordered properties, std::string_view meaning = "")
{
    ordered schema = meaning.empty() ? ordered{{"type", "object"}} : described(meaning, "object");
    schema["properties"] = std::move(properties);
    schema["additionalProperties"] = false;
    return schema;
}

ordered number_range(const rig_key &key)
{
    ordered range = ordered::object();
    if (key.least > key.low) {
        range["minimum"] = key.least;
    } else if (key.low != -unlimited) {
        range[key.low_is_allowed ? "minimum" : "exclusiveMinimum"] = key.low;
    }
    if (const double most = std::min(key.high, key.most); most != unlimited) {
        range["maximum"] = most;
    }
    return range;
}

/* Bounds hold for numbers only, the other words for { value = 100, tolerance = 0.05 } only. */
void allow_tolerance(ordered &schema, const ordered &range)
{
    ordered value = {{"type", "number"}};
    value.update(range);
    if (schema.contains("inf")) {
        value["inf"] = true;
    }
    schema["type"] = {"number", "object"};
    schema["properties"] = {{"value", std::move(value)}, {"tolerance", {{"$ref", "#/$defs/tolerance"}}}};
    schema["required"] = {"value"};
    schema["additionalProperties"] = false;
}

ordered schema_of(const rig_key &key)
{
    static constexpr const char *types[] = {"number", "integer", "boolean", "string", "string"};
    ordered schema = described(key.meaning, types[static_cast<int>(key.type)]);
    schema["section"] = key.path.substr(0, key.path.find('.'));
    add_unit(schema, key.path);
    if (const ordered value = default_of(key); !value.is_null()) {
        schema["default"] = value;
    }
    if (key.infinity_is_allowed) {
        schema["inf"] = true;
    }
    const ordered range = number_range(key);
    schema.update(range);
    if (key.type == key_type::choice) {
        schema["enum"] = key.choices;
    }
    if (key.type == key_type::text) {
        schema["maxLength"] = text_bytes_max;
    }
    if (key.type == key_type::number) {
        allow_tolerance(schema, range);
    }
    return schema;
}

ordered schema_of(const section_key &key)
{
    ordered schema = described(key.meaning, "number");
    add_unit(schema, key.name);
    if (std::isfinite(key.low)) {
        schema["minimum"] = key.low;
    }
    if (std::isfinite(key.high)) {
        schema["maximum"] = key.high;
    }
    return schema;
}

/* Lists of numbers: the bounds are those of each. */
ordered list_of_numbers(ordered schema, std::size_t least, std::size_t most)
{
    ordered item = {{"type", "number"}};
    for (const char *const bound : {"minimum", "maximum"}) {
        if (schema.contains(bound)) {
            item[bound] = schema[bound];
            schema.erase(bound);
        }
    }
    schema["type"] = "array";
    schema["items"] = std::move(item);
    schema["minItems"] = least;
    schema["maxItems"] = most;
    return schema;
}

ordered axes_schema(std::string_view meaning)
{
    ordered axes = ordered::object();
    for (std::size_t axis = 0; axis < side_axis_names.size(); axis++) {
        ordered keys = ordered::object();
        for (const section_key &key : side_axis_keys(axis)) {
            keys[std::string(key.name)] = schema_of(key);
        }
        axes[std::string(side_axis_names[axis])] =
            section_of(std::move(keys), "the robot's axis " + std::string(side_axis_names[axis]));
    }
    return section_of(std::move(axes), meaning);
}

ordered wrench_schema(std::string_view meaning)
{
    ordered keys = ordered::object();
    for (const section_key &key : wrench_keys()) {
        keys[std::string(key.name)] = schema_of(key);
    }
    ordered &crosstalk = keys["crosstalk"];
    crosstalk["type"] = "array";
    crosstalk["minItems"] = crosstalk["maxItems"] = 6;
    crosstalk["items"] = list_of_numbers(ordered::object(), 6, 6);
    return section_of(std::move(keys), meaning);
}

ordered orders_schema(std::string_view meaning)
{
    ordered keys = ordered::object();
    for (const section_key &key : order_keys()) {
        keys[std::string(key.name)] = schema_of(key);
    }
    keys["line_m"] = list_of_numbers(keys["line_m"], 2, 3);
    keys["joint"]["type"] = "integer";
    keys["follow"]["type"] = "boolean";
    keys["follow"]["const"] = true;
    ordered order = section_of(std::move(keys));
    order["required"] = {"at_s"};
    ordered orders = described(meaning, "array");
    orders["items"] = std::move(order);
    return orders;
}

ordered signals_schema(std::string_view meaning)
{
    ordered signals = ordered::object();
    for (const std::string_view name : signal_names) {
        ordered signal = {{"description", "where the record keeps " + std::string(name)},
                          {"type", {"string", "object"}}};
        add_unit(signal, name);
        signal["properties"] = {{"column", described("column of the record's file", "string")},
                                {"scale", described("factor from the column to the signal", "number")},
                                {"offset", described("added after the factor", "number")}};
        signal["required"] = {"column"};
        signal["additionalProperties"] = false;
        signals[std::string(name)] = std::move(signal);
    }
    return section_of(std::move(signals), meaning);
}

ordered tolerances_schema(std::string_view meaning)
{
    ordered keys = ordered::object();
    for (const rig_key &key : rig_keys()) {
        if (key.type == key_type::number) {
            keys[std::string(key.path)] = {{"$ref", "#/$defs/tolerance"}};
        }
    }
    return section_of(std::move(keys), meaning);
}

/* Those of an arm that stand in no table have their units from their names as well. */
ordered with_units(ordered keys)
{
    for (const auto &[name, schema] : keys.items()) {
        add_unit(schema, name);
    }
    return keys;
}

template <class Keys>
ordered arm_numbers(const Keys &keys)
{
    ordered properties = ordered::object();
    for (const number_key &key : keys) {
        ordered schema = described(key.meaning, "number");
        properties[std::string(key.name)] =
            key.count == 1 ? schema : list_of_numbers(std::move(schema), key.count, key.count);
    }
    return properties;
}

template <std::size_t Count>
ordered one_of(std::string_view meaning, const std::array<std::string_view, Count> &words, std::size_t from = 0)
{
    ordered schema = described(meaning, "string");
    schema["enum"] = std::vector<std::string_view>(words.begin() + from, words.end());
    return schema;
}

ordered arm_schema()
{
    ordered frame = arm_numbers(frame_keys);
    frame["rpy_rad"] = list_of_numbers(described("roll, pitch and yaw of the frame, as in URDF", "number"), 3, 3);
    const ordered body = arm_numbers(body_keys);

    ordered base = body;
    base["is_free"] = described("the base floats; false: it is held", "boolean");
    base["position_m"] = list_of_numbers(described("of the base in the world, at the start", "number"), 3, 3);
    base["turn_rad"] = described("of a planar arm's base", "number");
    base["quaternion"] = list_of_numbers(described("of a spatial arm's base: w, x, y, z", "number"), 4, 4);
    base["gravity_m_per_s2"] = list_of_numbers(described("gravity in the world", "number"), 3, 3);

    ordered joint = frame;
    joint.update(arm_numbers(joint_keys));
    joint["name"] = described("name of the joint", "string");
    joint["link"] = section_of(with_units(body), "the link that the joint moves");

    ordered attitude = arm_numbers(attitude_keys);
    attitude["actuator"] = one_of("what turns the satellite", actuator_words);
    attitude["period_ticks"] = described("ticks between two commands of the attitude control", "integer");

    ordered joints = described("joints, from the base to the tool", "array");
    joints["items"] = section_of(with_units(joint));
    joints["maxItems"] = ARM_JOINTS_MAX;
    return section_of({{"name", described("name of the arm", "string")},
                       {"description", described("what arm it is", "string")},
                       {"kind", one_of("planar or spatial", kind_words, 1)},
                       {"integrator", one_of("method that integrates the arm", integrator_words)},
                       {"force", one_of("how a tick's force acts: held, or led by half a tick", force_words)},
                       {"substeps", described("integrator steps per tick", "integer")},
                       {"base", section_of(with_units(base), "the satellite that carries the arm")},
                       {"joint", std::move(joints)},
                       {"tool", section_of(with_units(frame), "frame of the tool in the last link")},
                       {"payload", section_of(with_units(body), "what the tool carries")},
                       {"attitude", section_of(with_units(attitude), "attitude control of the satellite")}},
                      "a whole arm, as `berth arm` prints it");
}

std::string_view meaning_of_section(std::string_view name)
{
    for (const section_meaning &section : section_meanings()) {
        if (section.name == name) {
            return section.meaning;
        }
    }
    return "";
}

/* By the sections of rig_keys(), in their order. */
ordered sections_of_keys()
{
    ordered sections = ordered::object();
    for (const rig_key &key : rig_keys()) {
        const std::size_t dot = key.path.find('.');
        const std::string section(key.path.substr(0, dot));
        if (!sections.contains(section)) {
            sections[section] = section_of(ordered::object(), meaning_of_section(section));
        }
        sections[section]["properties"][std::string(key.path.substr(dot + 1))] = schema_of(key);
    }
    ordered &arm = sections["manipulator"]["properties"]["arm"];
    arm["anyOf"] = {{{"type", "string"}}, {{"$ref", "#/$defs/arm"}}};
    arm.erase("type");
    return sections;
}

/* The name of a shipped rig, or the path of a file. */
ordered base_schema()
{
    ordered schema =
        described("what this file leaves out comes from there: a shipped rig, or the path of a rig file", "string");
    schema["anyOf"] = {{{"enum", names_of_files(shipped_rigs())}}, {{"pattern", R"(\.toml$)"}}};
    return schema;
}

bool is_number(const ordered &schema)
{
    const auto type = schema.find("type");
    return type != schema.end() && (*type == "number" || (type->is_array() && type->front() == "number"));
}

/* A number without a bound of its own gets the largest there is: TOML's inf is beyond it. */
void bound_numbers(ordered &schema)
{
    constexpr double most = std::numeric_limits<double>::max();
    if (schema.is_object() && is_number(schema) && !schema.contains("inf")) {
        if (!schema.contains("minimum") && !schema.contains("exclusiveMinimum")) {
            schema["minimum"] = -most;
        }
        if (!schema.contains("maximum") && !schema.contains("exclusiveMaximum")) {
            schema["maximum"] = most;
        }
    }
    for (ordered &inner : schema) {
        if (inner.is_structured()) {
            bound_numbers(inner);
        }
    }
}

constexpr const char *schema_meaning =
    "Keys, units, ranges and words of a rig file. JSON has no nan, so a schema cannot refuse it, and it does not "
    "compare "
    "one key with another, such as limits.position_min_m with limits.position_max_m: berth check FILE refuses both "
    "with file, line and key.";

} // namespace

std::string rig_schema_text()
{
    ordered properties = {{"name", described("name of the rig and of its logs", "string")},
                          {"description", described("what rig it is, in a sentence", "string")},
                          {"base", base_schema()},
                          {"assumed", described("sections and keys that count as not stated", "array")}};
    properties["assumed"]["items"] = {{"type", "string"}};
    properties.update(sections_of_keys());
    const std::pair<const char *, ordered (*)(std::string_view)> whole[] = {{"axis", axes_schema},
                                                                            {"wrench", wrench_schema},
                                                                            {"orders", orders_schema},
                                                                            {"signals", signals_schema},
                                                                            {"tolerances", tolerances_schema}};
    for (const auto &[name, make] : whole) {
        properties[name] = make(meaning_of_section(name));
    }
    ordered schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                      {"$id", rig_schema_file},
                      {"title", "Rig file of berth"},
                      {"description", schema_meaning}};
    schema.update(section_of(std::move(properties)));
    bound_numbers(schema); /* an arm's limits may be inf: its bounds stand in its own table */
    ordered tolerance = described("how far the value may be off, as a share of it", "number");
    tolerance.update({{"minimum", 0.0}, {"exclusiveMaximum", 1.0}});
    schema["$defs"] = {{"tolerance", std::move(tolerance)}, {"arm", arm_schema()}};
    return schema.dump(2) + "\n";
}

} // namespace berth
