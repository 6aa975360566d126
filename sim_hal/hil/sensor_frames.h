/* The frames that a simulated force sensor makes of a sample, by the layouts of can/berth.dbc: the other side of
 * firmware/sensor_layout.h. */
#ifndef SIM_HAL_HIL_SENSOR_FRAMES_H
#define SIM_HAL_HIL_SENSOR_FRAMES_H

#include <array>
#include <cstddef>
#include <cstdint>

#include "../../firmware/sensor_layout.h"
#include "../../hal/hal.h"

namespace berth
{

struct sensor_frames {
    std::array<hal_frame, SENSOR_FRAMES_MAX> frames{};
    std::size_t count = 0; /* 0: nothing could be packed */
};

/* Values within the range of the layout; rounded to its steps. `counter` counts samples. */
sensor_frames make_sensor_frames(sensor_layout layout, const wrench &sample, std::uint32_t counter);

} // namespace berth

#endif
