#include "sample_age.h"

#include <algorithm>
#include <cstdint>

namespace berth
{

namespace
{

constexpr double ns_per_ms = 1e6;

} // namespace

rig with_age_as_delay(const rig &given)
{
    rig made = given;
    made.sensor.delay_ms = static_cast<double>(given.sample_age_ns()) / ns_per_ms;
    return made;
}

rig with_delay_of_age(const rig &found, const rig &given)
{
    rig made = found;
    std::int64_t delay_ns = ns_from_ms(found.sensor.delay_ms);
    if (delay_ns == given.sample_age_ns()) {
        made.sensor.delay_ms = given.sensor.delay_ms;
        return made;
    }
    const std::int64_t sample_period_ns = config_sample_period_ns(&found.firmware);
    if (found.has_wandering_samples()) {
        delay_ns = std::max<std::int64_t>(0, delay_ns - sample_period_ns / 2);
    } else {
        const std::int64_t periods = (delay_ns + sample_period_ns - 1) / sample_period_ns;
        made.sensor.sample_phase_ms = static_cast<double>(periods * sample_period_ns - delay_ns) / ns_per_ms;
    }
    made.sensor.delay_ms = static_cast<double>(delay_ns) / ns_per_ms;
    return made;
}

} // namespace berth
