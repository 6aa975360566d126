#include "units.h"

#include <algorithm>

namespace berth
{

namespace
{

/* The first that ends a name is its unit, so that longer ones stand before their own endings. */
constexpr std::string_view unit_names[] = {"N_m_s_per_rad",
                                           "N_m_per_rad",
                                           "counts_per_m",
                                           "bit_per_s",
                                           "rad_per_s2",
                                           "rad_per_s",
                                           "N_per_m3",
                                           "N_per_m2",
                                           "N_s_per_m",
                                           "kg_per_m",
                                           "m_per_s2",
                                           "ms_per_s",
                                           "N_per_m",
                                           "m_per_s",
                                           "N_per_s",
                                           "s_per_m",
                                           "per_s",
                                           "per_N",
                                           "kg_m2",
                                           "N_m_s",
                                           "N_m2",
                                           "N_m",
                                           "frames",
                                           "ticks",
                                           "rad",
                                           "ppm",
                                           "kg",
                                           "Hz",
                                           "ms",
                                           "us",
                                           "N",
                                           "J",
                                           "W",
                                           "m",
                                           "s"};

} // namespace

std::string_view unit_of(std::string_view key)
{
    for (const std::string_view unit : unit_names) {
        if (key.size() > unit.size() && key.substr(key.size() - unit.size()) == unit &&
            std::string_view("_.").find(key[key.size() - unit.size() - 1]) != std::string_view::npos) {
            return unit;
        }
    }
    return "1";
}

std::string unit_text(std::string_view key)
{
    std::string unit(unit_of(key));
    if (unit == "1") {
        return "";
    }
    unit = unit.compare(0, 4, "per_") == 0 ? "1/" + unit.substr(4) : unit;
    if (const std::size_t per = unit.find("_per_"); per != std::string::npos) {
        unit.replace(per, 5, "/");
    }
    std::replace(unit.begin(), unit.end(), '_', ' ');
    return unit;
}

} // namespace berth
