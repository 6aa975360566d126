#include "written_digits.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "../formatted.h"

namespace berth
{

namespace
{

struct driving_signal {
    const char *name;
    const char *unit;
    std::vector<double> record::*values;
};

constexpr driving_signal driving_signals[] = {
    {"operator_force_N", "N", &record::operator_force_N},
    {"force_N", "N", &record::force_N},
    {"operator_position_m", "m", &record::operator_position_m},
    {"operator_velocity_m_per_s", "m/s", &record::operator_velocity_m_per_s},
};

int decade_of(double value)
{
    return static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-9));
}

/* 10^n that all values but one in a hundred are whole numbers of; 0 with twelve digits and more: as good as all. */
double unit_of_decade(const std::vector<double> &values, int decade)
{
    constexpr int digits_max = 12;
    for (int place = decade; place > decade - digits_max; place--) {
        const double unit = std::pow(10.0, place);
        const auto whole = std::count_if(values.begin(), values.end(), [&](double value) {
            return std::abs(value / unit - std::round(value / unit)) < 1e-3;
        });
        if (static_cast<double>(whole) >= 0.99 * static_cast<double>(values.size())) {
            return unit;
        }
    }
    return 0.0;
}

/* Levels like 10 N are exact as they are written, and so is what a coarse sensor gave the loop: what was rounded by
 * the writing is finer than the way from row to row, or has digits that nobody chooses. */
bool is_rounded(const std::vector<double> &values, double unit)
{
    constexpr double chosen = 3e-4; /* of the largest value: four digits and more */
    std::vector<double> changes;
    double largest = 0.0;
    for (std::size_t n = 1; n < values.size(); n++) {
        changes.push_back(std::abs(values[n] - values[n - 1]));
        largest = std::max(largest, std::abs(values[n]));
    }
    constexpr double about = 1.001; /* changes of one unit have rounding of their own */
    return !changes.empty() && unit <= about * std::max(chosen * largest, median_of(std::move(changes)));
}

/* Each value anywhere within half a unit; what stays the same was rounded alike. */
void round_otherwise(std::vector<double> &values, const std::vector<double> &units, std::mt19937 &engine)
{
    double written = 0.0;
    double off = 0.0;
    for (std::size_t n = 0; n < values.size(); n++) {
        if (n == 0 || values[n] != written) {
            off = static_cast<double>(engine()) / 4294967296.0 - 0.5;
        }
        written = values[n];
        values[n] += units[n] * off;
    }
}

} // namespace

std::vector<double> units_of_last_digits(const std::vector<double> &values)
{
    constexpr std::size_t many = 30; /* fewer may end in zeros by chance */
    std::map<int, std::vector<double>> by_decade;
    for (const double value : values) {
        if (value != 0.0) {
            by_decade[decade_of(value)].push_back(value);
        }
    }
    std::map<int, double> units;
    double finest = unlimited;
    for (const auto &[decade, of_decade] : by_decade) {
        if (of_decade.size() >= many) {
            units[decade] = unit_of_decade(of_decade, decade);
            finest = std::min(finest, units[decade]);
        }
    }
    std::vector<double> found(values.size(), 0.0);
    if (finest == unlimited || !is_rounded(values, finest)) {
        return found;
    }
    for (std::size_t n = 0; n < values.size(); n++) {
        const auto known = values[n] != 0.0 ? units.find(decade_of(values[n])) : units.end();
        found[n] = known != units.end() ? known->second : finest;
    }
    return found;
}

double rms_of_written_digits(block_model &manipulator, const rig &rig)
{
    constexpr int roundings = 8;
    const record &data = manipulator.data();
    if (data.is_from_this_firmware) {
        return 0.0;
    }
    std::vector<double> units[std::size(driving_signals)];
    bool any = false;
    for (std::size_t i = 0; i < std::size(driving_signals); i++) {
        units[i] = units_of_last_digits(data.*driving_signals[i].values);
        any = any || std::any_of(units[i].begin(), units[i].end(), [](double unit) { return unit > 0.0; });
    }
    std::vector<double> as_written;
    std::vector<double> moved;
    manipulator.error(rig, as_written);
    double largest_m = 0.0;
    std::mt19937 engine(1); /* the same record gives the same verdict */
    for (int rounding = 0; any && rounding < roundings; rounding++) {
        record other = data;
        for (std::size_t i = 0; i < std::size(driving_signals); i++) {
            round_otherwise(other.*driving_signals[i].values, units[i], engine);
        }
        block_model otherwise(block::manipulator, other, rig, manipulator.events(), held_out_parts::none);
        otherwise.error(rig, moved);
        for (std::size_t n = 0; n < moved.size(); n++) {
            moved[n] -= as_written[n];
        }
        largest_m = std::max(largest_m, rms_of(moved, manipulator.uses(), row_use::fit));
    }
    return largest_m;
}

std::string columns_with_few_digits(const record &data)
{
    constexpr double few = 1e-8; /* of the largest value: eight digits */
    std::string told;
    for (const driving_signal &signal : driving_signals) {
        const std::vector<double> units = units_of_last_digits(data.*signal.values);
        double unit = 0.0;
        double largest = 0.0;
        for (std::size_t n = 0; n < units.size(); n++) {
            unit = std::max(unit, units[n]);
            largest = std::max(largest, std::abs((data.*signal.values)[n]));
        }
        if (unit > few * largest) {
            told +=
                (told.empty() ? "" : ", ") + std::string(signal.name) + formatted(" to %.3g ", unit) + signal.unit;
        }
    }
    return told;
}

} // namespace berth
