#include "column_units.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace berth
{

namespace
{

constexpr double pound_force_N = 4.4482216152605; /* exact by definition, as are inch, foot and kgf */
constexpr double pi_rad = 3.14159265358979323846;

constexpr column_unit known_units[] = {
    {"m", "m", 1.0},
    {"meter", "m", 1.0},
    {"metre", "m", 1.0},
    {"dm", "m", 0.1},
    {"cm", "m", 0.01},
    {"mm", "m", 1e-3},
    {"um", "m", 1e-6},
    {"\xc2\xb5m", "m", 1e-6}, /* the micro sign, and the Greek letter */
    {"\xce\xbcm", "m", 1e-6},
    {"nm", "m", 1e-9},
    {"km", "m", 1e3},
    {"in", "m", 0.0254},
    {"inch", "m", 0.0254},
    {"ft", "m", 0.3048},
    {"N", "N", 1.0},
    {"newton", "N", 1.0},
    {"mN", "N", 1e-3},
    {"daN", "N", 10.0},
    {"kN", "N", 1e3},
    {"MN", "N", 1e6},
    {"gf", "N", 9.80665e-3},
    {"kgf", "N", 9.80665},
    {"kp", "N", 9.80665},
    {"lbf", "N", pound_force_N},
    {"lb", "N", pound_force_N},
    {"s", "s", 1.0},
    {"sec", "s", 1.0},
    {"second", "s", 1.0},
    {"seconds", "s", 1.0},
    {"ms", "s", 1e-3},
    {"msec", "s", 1e-3},
    {"us", "s", 1e-6},
    {"usec", "s", 1e-6},
    {"\xc2\xb5s", "s", 1e-6},
    {"\xce\xbcs", "s", 1e-6},
    {"ns", "s", 1e-9},
    {"min", "s", 60.0},
    {"m_per_s", "m_per_s", 1.0},
    {"m/s", "m_per_s", 1.0},
    {"cm_per_s", "m_per_s", 0.01},
    {"cm/s", "m_per_s", 0.01},
    {"mm_per_s", "m_per_s", 1e-3},
    {"mm/s", "m_per_s", 1e-3},
    {"um_per_s", "m_per_s", 1e-6},
    {"um/s", "m_per_s", 1e-6},
    {"in_per_s", "m_per_s", 0.0254},
    {"in/s", "m_per_s", 0.0254},
    {"m_per_s2", "m_per_s2", 1.0},
    {"m/s2", "m_per_s2", 1.0},
    {"m/s^2", "m_per_s2", 1.0},
    {"m/s\xc2\xb2", "m_per_s2", 1.0},
    {"mm_per_s2", "m_per_s2", 1e-3},
    {"mm/s2", "m_per_s2", 1e-3},
    {"mm/s^2", "m_per_s2", 1e-3},
    {"cm_per_s2", "m_per_s2", 0.01},
    {"cm/s2", "m_per_s2", 0.01},
    {"cm/s^2", "m_per_s2", 0.01},
    {"gal", "m_per_s2", 0.01},
    {"rad", "rad", 1.0},
    {"mrad", "rad", 1e-3},
    {"deg", "rad", pi_rad / 180.0},
    {"\xc2\xb0", "rad", pi_rad / 180.0},
    {"rad_per_s", "rad_per_s", 1.0},
    {"rad/s", "rad_per_s", 1.0},
    {"deg_per_s", "rad_per_s", pi_rad / 180.0},
    {"deg/s", "rad_per_s", pi_rad / 180.0},
    {"Nm", "Nm", 1.0},
    {"N_m", "Nm", 1.0},
    {"kg", "kg", 1.0},
    {"V", "V", 1.0},
    {"mV", "V", 1e-3},
    {"volt", "V", 1.0},
    {"A", "A", 1.0},
    {"mA", "A", 1e-3},
    {"Hz", "Hz", 1.0},
    {"kHz", "Hz", 1e3},
    {"Pa", "Pa", 1.0},
    {"kPa", "Pa", 1e3},
    {"bar", "Pa", 1e5},
    {"degC", "degC", 1.0},
    {"\xc2\xb0\x43", "degC", 1.0},
    {"counts", "counts", 1.0},
    {"%", "%", 1.0},
};

constexpr std::string_view of_motion[] = {"m", "N", "s", "m_per_s", "m_per_s2"};

std::string small_letters(std::string_view text)
{
    std::string small(text);
    std::transform(small.begin(), small.end(), small.begin(), [](unsigned char c) { return std::tolower(c); });
    return small;
}

std::string_view without_blanks(std::string_view text)
{
    while (!text.empty() && text.front() == ' ') {
        text.remove_prefix(1);
    }
    while (!text.empty() && text.back() == ' ') {
        text.remove_suffix(1);
    }
    return text;
}

constexpr std::pair<char, char> brackets[] = {{'[', ']'}, {'(', ')'}};

} // namespace

const column_unit *find_unit(std::string_view text)
{
    text = without_blanks(text);
    for (const auto &[open, close] : brackets) {
        if (text.size() > 2 && text.front() == open && text.back() == close) {
            text = without_blanks(text.substr(1, text.size() - 2));
        }
    }
    const auto exact = std::find_if(std::begin(known_units), std::end(known_units),
                                    [&](const column_unit &known) { return known.name == text; });
    if (exact != std::end(known_units)) {
        return &*exact;
    }
    const column_unit *only = nullptr;
    const std::string small = small_letters(text);
    for (const column_unit &known : known_units) {
        if (small_letters(known.name) != small) {
            continue;
        }
        if (only != nullptr ||
            std::find(std::begin(of_motion), std::end(of_motion), known.si) == std::end(of_motion)) {
            return nullptr;
        }
        only = &known;
    }
    return only;
}

column_name split_column_name(std::string_view name)
{
    name = without_blanks(name);
    for (const auto &[open, close] : brackets) {
        const std::size_t at = name.rfind(open);
        if (at == std::string_view::npos || name.back() != close || at + 2 >= name.size()) {
            continue;
        }
        const std::string_view unit = without_blanks(name.substr(at + 1, name.size() - at - 2));
        if (open == '[' || find_unit(unit) != nullptr) {
            return {without_blanks(name.substr(0, at)), unit};
        }
    }
    for (std::size_t at = name.find('_'); at != std::string_view::npos; at = name.find('_', at + 1)) {
        if (find_unit(name.substr(at + 1)) != nullptr) {
            return {name.substr(0, at), name.substr(at + 1)};
        }
    }
    return {name, {}};
}

std::string plain_column_name(std::string_view name)
{
    const column_name parts = split_column_name(name);
    const column_unit *const unit = find_unit(parts.unit);
    const bool has_brackets = !parts.unit.empty() && (name.back() == ']' || name.back() == ')');
    return has_brackets && unit != nullptr && unit->factor == 1.0
               ? std::string(parts.bare) + "_" + std::string(unit->si)
               : std::string(name);
}

bool is_name_of_time(std::string_view name)
{
    const column_name parts = split_column_name(name);
    const column_unit *const unit = find_unit(parts.unit);
    if (!parts.unit.empty() && (unit == nullptr || unit->si != "s")) {
        return false;
    }
    constexpr std::array<std::string_view, 8> names = {"t",    "time",     "stamp",     "timestamp",
                                                       "date", "datetime", "date_time", "date/time"};
    return std::find(names.begin(), names.end(), small_letters(parts.bare)) != names.end();
}

std::optional<other_unit> unit_other_than(std::string_view si, std::string_view name, std::string_view row_unit)
{
    for (const auto &[text, is_of_row] : {std::pair(split_column_name(name).unit, false), {row_unit, true}}) {
        if (text.empty()) {
            continue;
        }
        const column_unit *const unit = find_unit(text);
        if (unit == nullptr || unit->si != si) {
            return other_unit{std::string(text), std::nullopt, is_of_row};
        }
        if (unit->factor != 1.0) {
            return other_unit{std::string(text), unit->factor, is_of_row};
        }
    }
    return std::nullopt;
}

bool is_rotary_counterpart(std::string_view si, std::string_view unit)
{
    constexpr std::pair<std::string_view, std::string_view> counterparts[] = {
        {"m", "rad"}, {"N", "Nm"}, {"m_per_s", "rad_per_s"}};
    const column_unit *const found = find_unit(unit);
    return found != nullptr && found->factor == 1.0 &&
           std::find(std::begin(counterparts), std::end(counterparts), std::pair(si, found->si)) !=
               std::end(counterparts);
}

} // namespace berth
