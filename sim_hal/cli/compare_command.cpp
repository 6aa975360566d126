#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "../../hal/rig/axes.h"
#include "../../hal/rig/keys.h"
#include "../../hal/rig/knowledge.h"
#include "../../hal/rig/orders.h"
#include "../../hal/rig/units.h"
#include "../effects/effect.h"
#include "colour.h"
#include "commands.h"
#include "log_condition.h"
#include "log_result.h"
#include "number.h"
#include "python_script.h"
#include "run_folder.h"
#include "short_number.h"

namespace berth
{

namespace
{

constexpr const char *row_format = "  %-36s %-24s %s\n";
constexpr std::size_t width_of_a = 24; /* the column of A in it */

struct compared_run {
    std::string log;
    struct rig rig;
    nlohmann::json result;
    log_state state;
};

struct differing_key {
    std::string key;
    std::string a;
    std::string b;
};

compared_run read_run(const std::string &path)
{
    compared_run run{log_of(path), {}, {}, {}};
    const run_result result = read_result(run.log, run.rig, run.state);
    print_damage(run.log, run.state.condition, run.state.ticks);
    run.result = as_json(result, run.rig);
    return run;
}

/* Sums and products of one number may differ in their last digit. */
bool are_equal(const rig &a, const rig &b, const rig_key &key, const std::string &of_a, const std::string &of_b)
{
    constexpr double rounded = 1e-12;
    if (of_a == of_b || key.type != key_type::number) {
        return of_a == of_b;
    }
    const double value_a = value_of(a, key.path);
    const double value_b = value_of(b, key.path);
    return std::abs(value_a - value_b) <= rounded * std::max(std::abs(value_a), std::abs(value_b));
}

template <auto print>
std::string text_of(const rig &of)
{
    std::ostringstream text;
    print(of, text);
    return text.str();
}

/* What is compared as a whole. */
struct whole_section {
    const char *name;
    std::string (*text)(const rig &);
};

constexpr whole_section whole_sections[] = {{"axis, wrench", text_of<print_axes>},
                                            {"orders", text_of<print_orders>},
                                            {"signals, tolerances", text_of<print_knowledge>},
                                            {"manipulator.arm", [](const rig &of) { return of.arm_text; }}};

std::vector<differing_key> differences(const rig &a, const rig &b)
{
    std::vector<differing_key> found;
    for (const rig_key &key : rig_keys()) {
        const std::string of_a = value_text(a, key);
        const std::string of_b = value_text(b, key);
        if (!are_equal(a, b, key, of_a, of_b)) {
            found.push_back({std::string(key.path), of_a, of_b});
        }
    }
    for (const whole_section &section : whole_sections) {
        const std::string of_a = section.text(a);
        const std::string of_b = section.text(b);
        if (of_a != of_b) {
            found.push_back({section.name, of_a.empty() ? "none" : "stated",
                             of_b.empty()   ? "none"
                             : of_a.empty() ? "stated"
                                            : "stated otherwise"});
        }
    }
    return found;
}

std::string cell_text(const nlohmann::json &value)
{
    return value.is_null()     ? "none"
           : value.is_number() ? four_digits(value.get<double>())
           : value.is_string() ? value.get<std::string>()
                               : value.dump();
}

/* In the colour of its answer, and blanks up to so many letters, which a colour is none of. */
std::string verdict_cell(const nlohmann::json &result, std::size_t width)
{
    const std::string name = cell_text(result.at("verdict"));
    const nlohmann::json &stable = result.at("stable");
    const ink colour = stable.is_null() ? ink::yellow : stable == true ? ink::green : ink::red;
    return coloured(stdout, colour, name) + std::string(name.size() < width ? width - name.size() : 0, ' ');
}

/* "predicted -0.25", "0.61", or "none". */
std::string growth_text(const nlohmann::json &result)
{
    const nlohmann::json &growth = result.at("growth");
    return growth.is_null() ? "none"
                            : std::string(growth.at("origin") == "predicted" ? "predicted " : "") +
                                  four_digits(growth.at("growth_per_s").get<double>());
}

/* Of a number; other values as they are. */
std::string six_digits(const std::string &value)
{
    const char *end = nullptr;
    const double number = number_at<double>(value.c_str(), &end);
    return end != value.c_str() && *end == '\0' ? short_number(number) : value;
}

nlohmann::json as_json(const compared_run &run)
{
    nlohmann::json json = {{"log", run.log}, {"rig", run.rig.name}};
    for (const char *const key :
         {"verdict", "stable", "growth", "growth_per_s", "frequency_Hz", "peak_force_N", "version", "config_hash"}) {
        json[key] = run.result.at(key);
    }
    json.update(as_json(run.state.condition));
    return json;
}

nlohmann::json as_json(const std::vector<differing_key> &found)
{
    nlohmann::json list = nlohmann::json::array();
    for (const differing_key &one : found) {
        list.push_back({{"key", one.key}, {"unit", unit_of(one.key)}, {"a", one.a}, {"b", one.b}});
    }
    return list;
}

void print_comparison(const compared_run &a, const compared_run &b, const std::vector<differing_key> &found)
{
    std::printf("A  %s\nB  %s\n", a.log.c_str(), b.log.c_str());
    std::printf(row_format, "", "A", "B");
    const auto print_row = [&](const char *title, const char *key) {
        std::printf(row_format, title, cell_text(a.result.at(key)).c_str(), cell_text(b.result.at(key)).c_str());
    };
    std::printf("  %-36s %s %s\n", "verdict", verdict_cell(a.result, width_of_a).c_str(),
                verdict_cell(b.result, 0).c_str());
    std::printf(row_format, "growth (1/s)", growth_text(a.result).c_str(), growth_text(b.result).c_str());
    if (!a.result.at("frequency_Hz").is_null() || !b.result.at("frequency_Hz").is_null()) {
        print_row("frequency (Hz)", "frequency_Hz");
    }
    print_row("peak force (N)", "peak_force_N");
    print_row("commit", "version");
    const auto spring_N = [](const compared_run &run) {
        return cell_text(
            run.result.value(nlohmann::json::json_pointer("/peak_force/true/force_N"), nlohmann::json()));
    };
    std::printf(row_format, "in the sensor's spring (N)", spring_N(a).c_str(), spring_N(b).c_str());
    std::printf("%s\n", found.empty() ? "no parameter differs" : "parameters that differ");
    for (const differing_key &one : found) {
        const std::string short_a = six_digits(one.a);
        const std::string short_b = six_digits(one.b);
        const bool is_told = short_a != short_b; /* else they differ beyond six digits */
        std::printf(row_format, one.key.c_str(), (is_told ? short_a : one.a).c_str(),
                    (is_told ? short_b : one.b).c_str());
    }
    for (const auto &[name, run] : {std::pair("A", &a), {"B", &b}}) {
        if (run->state.condition.is_cut) {
            std::printf("the file of %s is cut: compared up to the last whole tick%s\n", name,
                        time_of_end(run->state.condition).c_str());
        }
    }
}

} // namespace

int compare_command(const compare_arguments &arguments)
{
    if (!arguments.page.empty() && std::filesystem::path(arguments.page).extension() != ".html") {
        throw input_error(arguments.page + ": --page writes a page for a browser: let its name end in .html");
    }
    const compared_run a = read_run(arguments.a);
    const compared_run b = read_run(arguments.b);
    const std::vector<differing_key> found = differences(a.rig, b.rig);
    if (arguments.json) {
        print_json({{"a", as_json(a)}, {"b", as_json(b)}, {"differences", as_json(found)}});
    } else {
        print_comparison(a, b, found);
    }
    if (a.state.condition.damage || b.state.condition.damage) { /* a page would draw what is behind it, too */
        return exit_damaged;
    }
    return arguments.page.empty() ? 0
                                  : run_script("compare.py", "compare: draws " + arguments.page,
                                               {a.log, b.log, "--out", arguments.page});
}

} // namespace berth
