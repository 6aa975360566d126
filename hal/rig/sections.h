/* The sections of a rig file: what each is about, and the keys of those that are read as a whole. */
#ifndef HAL_RIG_SECTIONS_H
#define HAL_RIG_SECTIONS_H

#include <array>
#include <limits>
#include <string_view>
#include <vector>

namespace berth
{

struct section_meaning {
    std::string_view name;
    std::string_view meaning;
};

/* In the order of rig_keys(), then those with readers of their own. */
const std::vector<section_meaning> &section_meanings();

/* The key of a section that is read as a whole; bounds are permitted values. */
struct section_key {
    std::string_view name;
    std::string_view meaning;
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
};

/* As enum side_axis has them. */
constexpr std::array<std::string_view, 5> side_axis_names = {"y", "z", "rx", "ry", "rz"};

std::vector<section_key> side_axis_keys(std::size_t axis);
std::vector<section_key> wrench_keys();
std::vector<section_key> order_keys();

} // namespace berth

#endif
