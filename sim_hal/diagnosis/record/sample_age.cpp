#include "sample_age.h"

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
    if (!given.has_wandering_samples()) {
        made.sensor.delay_ms = static_cast<double>(given.sample_age_ns()) / ns_per_ms;
    }
    return made;
}

rig with_delay_of_age(const rig &found, const rig &given)
{
    rig made = found;
    const std::int64_t age_ns = ns_from_ms(found.sensor.delay_ms);
    if (given.has_wandering_samples() || age_ns == given.sample_age_ns()) {
        made.sensor.delay_ms = given.sensor.delay_ms;
        return made;
    }
    const std::int64_t sample_period_ns = config_sample_period_ns(&found.firmware);
    const std::int64_t periods = (age_ns + sample_period_ns - 1) / sample_period_ns;
    made.sensor.delay_ms = static_cast<double>(age_ns) / ns_per_ms;
    made.sensor.sample_phase_ms = static_cast<double>(periods * sample_period_ns - age_ns) / ns_per_ms;
    return made;
}

} // namespace berth
