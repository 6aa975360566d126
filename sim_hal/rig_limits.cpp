#include "rig_limits.h"

#include <algorithm>
#include <exception>
#include <thread>

#include "../hal/rig/rig_file.h"
#include "bounce_limits.h"
#include "flight_limits.h"
#include "prediction.h"
#include "stability/equivalent_loop.h"
#include "stability/physical_parameter.h"
#include "stability/shared_rows.h"

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
    const std::vector<std::string_view> keys = physical_parameters(rig);
    std::vector<parameter_limits> parameters(keys.size());
    std::vector<std::exception_ptr> errors(keys.size()); /* none may leave a thread */
    const auto find = [&](int i) {
        const auto at = static_cast<std::size_t>(i);
        try {
            parameters[at] = find_limits(rig, keys[at], linear, how);
            if (amplitude_m == 0.0) {
                cut_by_flight(parameters[at], rig, how);
                cut_by_bounces(parameters[at], rig);
            }
        } catch (const input_error &) {
            errors[at] = std::current_exception();
        }
    };
    const auto tell = [&](int done) {
        if (next && static_cast<std::size_t>(done) < keys.size()) {
            next(keys[static_cast<std::size_t>(done)]);
        }
    };
    const auto threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    share_rows(static_cast<int>(keys.size()), threads, tell, [&] { return find; });
    for (const std::exception_ptr &error : errors) {
        if (error) {
            std::rethrow_exception(error);
        }
    }
    return parameters;
}

} // namespace berth
