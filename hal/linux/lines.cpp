#include "lines.h"

#include "hardware_error.h"

namespace berth
{

std::array<line_wiring, rig_line_count> wiring_of(const target_rig &target)
{
    return {{{"target.emergency_stop_line", target.emergency_stop_line, GPIO_IN_WITH_EDGES,
              target.emergency_stop_active_low},
             {"target.enable_line", target.enable_line, GPIO_IN, target.enable_active_low},
             {"target.heartbeat_line", target.heartbeat_line, GPIO_OUT, false},
             {"target.tick_line", target.tick_line, GPIO_OUT, false},
             {"target.fault_line", target.fault_line, GPIO_OUT, false}}};
}

lines::lines(const target_rig &target)
{
    std::size_t number = 0;
    for (const line_wiring &wiring : wiring_of(target)) {
        if (!wiring.name.empty()) {
            char error[200] = "";
            lines_[number].reset(gpio_line_open(target.gpio_chip.c_str(), wiring.name.c_str(), wiring.direction,
                                                wiring.is_active_low, error, sizeof error));
            if (lines_[number] == nullptr) {
                throw hardware_error(std::string(wiring.key) + ": " + error);
            }
        }
        number++;
    }
}

std::uint8_t lines::get(rig_line line, std::uint8_t level_if_broken) const
{
    const int level = gpio_line_get(of(line));
    return level < 0 ? level_if_broken : static_cast<std::uint8_t>(level);
}

void lines::set(rig_line line, std::uint8_t level)
{
    std::uint8_t &set_level = set_levels_[static_cast<std::size_t>(line)];
    if (of(line) != nullptr && level != set_level) {
        gpio_line_set(of(line), level);
        set_level = level;
    }
}

bool lines::next_edge(rig_line line, gpio_edge &edge) const
{
    return of(line) != nullptr && gpio_line_next_edge(of(line), &edge) == 1;
}

} // namespace berth
