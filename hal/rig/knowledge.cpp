#include "knowledge.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "keys.h"
#include "names.h"

namespace berth
{

void set_tolerance(rig &rig, const std::string &path, const toml::node &share, const std::string &where)
{
    const rig_key *const key = find_key(path);
    if (key == nullptr) {
        fail(where, {path, unknown_key_words(path)});
    }
    const double value = share.value<double>().value_or(-1.0);
    if (key->type != key_type::number || !(value >= 0.0 && value < 1.0)) {
        fail(where,
             {path, "its tolerance must be a share of it, from 0 to less than 1 (is " + text_of(share) + ")"});
    }
    const auto known = std::find_if(rig.tolerances.begin(), rig.tolerances.end(),
                                    [&](const tolerance &one) { return one.key == path; });
    if (known != rig.tolerances.end()) { /* the base's */
        known->share = value;
        return;
    }
    rig.tolerances.push_back({path, value});
}

const toml::node &split_tolerance(rig &rig, const std::string &path, const toml::node &node,
                                  const std::string &where)
{
    const toml::table *const table = node.as_table();
    if (table == nullptr) {
        return node;
    }
    for (const auto &[name, entry] : *table) {
        if (name.str() != "value" && name.str() != "tolerance") {
            fail(where, {path + "." + std::string(name.str()),
                         "unknown; a number may read { value = 100, tolerance = 0.05 }"});
        }
    }
    const toml::node *const value = table->get("value");
    if (value == nullptr) {
        fail(where, {path, "has no value; write { value = 100, tolerance = 0.05 }"});
    }
    if (const toml::node *const share = table->get("tolerance")) {
        set_tolerance(rig, path, *share, where);
    }
    return *value;
}

void read_signal(rig &rig, const std::string &name, const toml::node &node, const std::string &where)
{
    const std::string path = "signals." + name;
    if (std::find(signal_names.begin(), signal_names.end(), name) == signal_names.end()) {
        std::string message = "no signal of a record; there are";
        for (const auto known : signal_names) {
            message += (known == signal_names.front() ? " " : ", ") + std::string(known);
        }
        fail(where, {path, message});
    }
    signal_source source{name, "", 1.0, 0.0};
    if (const auto *column = node.as_string()) {
        source.column = column->get();
    } else if (const toml::table *const table = node.as_table()) {
        for (const auto &[entry, value] : *table) {
            const std::string key(entry.str());
            if (key == "column" && value.is_string()) {
                source.column = value.as_string()->get();
            } else if ((key == "scale" || key == "offset") && value.is_number()) {
                (key == "scale" ? source.scale : source.offset) = value.value<double>().value_or(0.0);
            } else {
                fail(where, {std::string(path).append(".").append(key),
                             "must be column = \"...\", scale = a number or offset = a number"});
            }
        }
    }
    if (source.column.empty()) {
        fail(where, {path, "names no column; write { column = \"vir_V\", scale = 35.15 }"});
    }
    if (!std::isfinite(source.scale) || source.scale == 0.0 || !std::isfinite(source.offset)) {
        fail(where, {path, "scale and offset must be finite numbers, and scale not 0"});
    }
    rig.signals.erase(std::remove_if(rig.signals.begin(), rig.signals.end(), /* the base's */
                                     [&](const signal_source &known) { return known.signal == name; }),
                      rig.signals.end());
    rig.signals.push_back(source);
}

void print_knowledge(const rig &rig, std::ostringstream &text)
{
    const auto number = [](double value) {
        char digits[32];
        const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
        const std::string result(digits, end);
        return result.find_first_not_of("-0123456789") == std::string::npos ? result + ".0" : result;
    };
    text << (rig.tolerances.empty() ? "" : "\n[tolerances]\n");
    for (const tolerance &known : rig.tolerances) {
        text << in_quotes(known.key) << " = " << number(known.share) << "\n";
    }
    text << (rig.signals.empty() ? "" : "\n[signals]\n");
    for (const signal_source &source : rig.signals) {
        text << source.signal << " = { column = " << in_quotes(source.column) << ", scale = " << number(source.scale)
             << ", offset = " << number(source.offset) << " }\n";
    }
}

} // namespace berth
