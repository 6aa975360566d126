#include "scan_grid.h"

#include <algorithm>
#include <cmath>

#include "../../hal/rig/rig_file.h"

namespace berth
{

void bisect(double &good, double &bad, const std::function<bool(double)> &is_good, double tolerance)
{
    const double narrow = tolerance * std::max(std::abs(good), std::abs(bad));
    while (std::abs(bad - good) > narrow) {
        const double middle = 0.5 * (good + bad);
        if (middle == good || middle == bad) {
            return;
        }
        (is_good(middle) ? good : bad) = middle;
    }
}

double longest_step(const rig &rig, parameter_scale kind, double range, const scan &how)
{
    constexpr double steps_max = 20000.0; /* some seconds */
    return kind == parameter_scale::delay
               ? std::max(1e3 * config_period_s(&rig.firmware) * how.share_of_period, range / steps_max)
               : unlimited;
}

std::vector<double> scan_grid(const rig &rig, const rig_key &key, parameter_scale kind, double own, const scan &how)
{
    const auto is_permitted = [&](double value) { return with_value(rig, key, value).has_value(); };
    const double centre = own > 0.0 ? own : usual_value(rig, kind);
    const double factor = kind == parameter_scale::delay ? std::min(10.0, how.factor) : how.factor;
    double low = centre / factor;
    if (key.low_is_allowed && is_permitted(0.0)) {
        low = 0.0;
    } else if (!is_permitted(low)) {
        double permitted = own;
        bisect(permitted, low, is_permitted);
        low = permitted;
    }
    const double step_max = longest_step(rig, kind, centre * factor, how);
    std::vector<double> grid;
    double value = low;
    while (value < centre * factor) {
        grid.push_back(value);
        value += std::min(how.step * std::max(value, centre / factor), step_max);
    }
    grid.push_back(centre * factor);
    grid.push_back(own);
    std::sort(grid.begin(), grid.end());
    grid.erase(std::unique(grid.begin(), grid.end()), grid.end());
    return grid;
}

} // namespace berth
