#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/names.h"
#include "../../hal/rig/robot_file.h"
#include "../../hal/rig/units.h"
#include "../berth.h"
#include "bindings.h"

namespace nb = nanobind;

namespace berth
{

namespace
{

std::string key_of(const std::string &setting)
{
    return setting.substr(0, setting.find('='));
}

std::vector<std::string> with_setting(std::vector<std::string> settings, const std::string &setting)
{
    const std::string key = key_of(setting);
    for (std::string &one : settings) {
        if (key_of(one) == key) {
            one = setting;
            return settings;
        }
    }
    settings.push_back(setting);
    return settings;
}

const rig_key &known_key(const std::string &path)
{
    const rig_key *const key = find_key(path);
    if (key == nullptr) {
        throw input_error("rig", path, "unknown key; the nearest known one is " + std::string(nearest_key(path)));
    }
    return *key;
}

nb::object value_of_key(const rig &of, const std::string &path)
{
    const rig_key &key = known_key(path);
    void *const member = key.member(const_cast<rig &>(of));
    switch (key.type) {
    case key_type::number:
        return nb::float_(*static_cast<double *>(member));
    case key_type::integer:
        return nb::int_(*static_cast<std::int64_t *>(member));
    case key_type::boolean:
        return nb::bool_(key.is_bool ? *static_cast<bool *>(member) : *static_cast<std::int32_t *>(member) != 0);
    case key_type::choice:
        return nb::cast(std::string(key.choices.at(static_cast<std::size_t>(*static_cast<std::int32_t *>(member)))));
    case key_type::text:
        break;
    }
    return nb::cast(*static_cast<std::string *>(member));
}

} // namespace

rig_handle::rig_handle(std::string text, std::string origin, std::string name, std::vector<std::string> settings,
                       std::string robot)
    : text_(std::move(text)), origin_(std::move(origin)), name_(std::move(name)), settings_(std::move(settings)),
      robot_(std::move(robot)), resolved_(resolve(settings_))
{
}

rig_handle::rig_handle(berth::rig resolved)
    : text_(print_rig(resolved)), origin_(resolved.name), name_(resolved.name), resolved_(std::move(resolved))
{
}

rig_handle rig_handle::load(const std::string &name_or_path, const std::vector<std::string> &settings,
                            const std::string &robot)
{
    for (const shipped_file &shipped : shipped_rigs()) {
        if (name_or_path == shipped.name) {
            return {shipped.text, name_or_path + ".toml", "", settings, robot};
        }
    }
    const std::string name = load_rig(name_or_path).name; /* says what is wrong with the path */
    return {read_file(name_or_path, written_bytes_max), name_or_path, name, settings, robot};
}

rig_handle rig_handle::parse(const std::string &text, const std::string &origin,
                             const std::vector<std::string> &settings, const std::string &robot)
{
    return {text, origin, origin, settings, robot};
}

rig rig_handle::resolve(const std::vector<std::string> &settings) const
{
    std::optional<robot_preset> preset;
    if (!robot_.empty()) {
        preset = load_robot(robot_);
    }
    rig made = parse_rig(text_, origin_, settings, preset ? &*preset : nullptr);
    if (made.name.empty()) {
        made.name = name_;
    }
    return made;
}

void rig_handle::set(const std::string &setting)
{
    std::vector<std::string> changed = with_setting(settings_, setting);
    resolved_ = resolve(changed);
    settings_ = std::move(changed);
}

void bind_rig(nb::module_ &module)
{
    nb::class_<rig_handle>(module, "Rig", "A rig file and the settings on top of it.")
        .def_static("load", &rig_handle::load, nb::arg("name_or_path"), nb::arg("settings"), nb::arg("robot"))
        .def_static("parse", &rig_handle::parse, nb::arg("text"), nb::arg("origin"), nb::arg("settings"),
                    nb::arg("robot"))
        .def("set", &rig_handle::set, nb::arg("setting"))
        .def("copy", [](const rig_handle &of) { return rig_handle(of); })
        .def(
            "get", [](const rig_handle &of, const std::string &key) { return value_of_key(of.get(), key); },
            nb::arg("key"))
        .def("refuse_unstated", [](const rig_handle &of) { refuse_unstated(of.get(), of.origin()); })
        .def_prop_ro("settable", [](const rig_handle &of) { return is_settable(of.get()); })
        .def_prop_ro("name", [](const rig_handle &of) { return of.get().name; })
        .def_prop_ro("description", [](const rig_handle &of) { return of.get().description; })
        .def_prop_ro("settings", [](const rig_handle &of) { return of.settings(); })
        .def_prop_ro("toml", [](const rig_handle &of) { return print_config(of.get()); })
        .def_prop_ro("hash", [](const rig_handle &of) { return config_hash(of.get()); })
        .def_prop_ro("assumed",
                     [](const rig_handle &of) {
                         std::vector<std::pair<std::string, std::string>> all;
                         for (const assumption &one : assumptions_of(of.get())) {
                             all.emplace_back(one.key, one.value);
                         }
                         return all;
                     })
        .def_prop_ro("delay_budget", [](const rig_handle &of) {
            std::vector<std::pair<std::string, double>> all;
            for (const delay_part &part : delay_budget_of(of.get()).parts()) {
                all.emplace_back(part.key, part.delay_ms);
            }
            return all;
        });
    module.def("keys", [] {
        std::vector<std::string> all;
        for (const rig_key &key : rig_keys()) {
            all.emplace_back(key.path);
        }
        return all;
    });
    module.def(
        "meaning", [](const std::string &key) { return std::string(known_key(key).meaning); }, nb::arg("key"));
    module.def(
        "unit", [](const std::string &key) { return unit_text(known_key(key).path); }, nb::arg("key"));
    module.def("shipped_rigs", [] { return names_of_files(shipped_rigs()); });
    module.def("shipped_robots", [] { return names_of_files(shipped_robots()); });
}

} // namespace berth
