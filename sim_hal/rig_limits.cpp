#include "rig_limits.h"

#include "bounce_limits.h"
#include "flight_limits.h"
#include "prediction.h"
#include "stability/equivalent_loop.h"
#include "stability/physical_parameter.h"

namespace berth
{

linear_view linear_view_at(double amplitude_m)
{
    /* A new finder each time: one that goes on from the value before may follow another mode there. */
    return [=](const rig &of) {
        return amplitude_m == 0.0 ? in_contact(of) : equivalent_finder(amplitude_m).find(of).linear;
    };
}

scan scan_at(const rig &rig, double amplitude_m)
{
    return amplitude_m == 0.0 ? fine_scan : is_slow_to_find(rig) ? scan_of_slow_ones : scan_of_harmonics;
}

std::vector<parameter_limits> limits_of(const rig &rig, double amplitude_m,
                                        const std::function<void(std::string_view)> &next)
{
    const linear_view linear = linear_view_at(amplitude_m);
    const scan how = scan_at(rig, amplitude_m);
    std::vector<parameter_limits> parameters;
    for (const std::string_view key : physical_parameters(rig)) {
        if (next) {
            next(key);
        }
        parameters.push_back(find_limits(rig, key, linear, how));
        if (amplitude_m == 0.0) {
            cut_by_flight(parameters.back(), rig, how);
            cut_by_bounces(parameters.back(), rig);
        }
    }
    return parameters;
}

} // namespace berth
