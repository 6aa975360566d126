#include "lines.h"

#include <algorithm>
#include <iterator>

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

seen_lines lines_of_machine()
{
    seen_lines seen{0, {}};
    seen.chips = gpio_for_each_line(
        [](void *context, const gpio_seen_line *line) {
            static_cast<std::vector<seen_line> *>(context)->push_back(
                {line->chip, line->chip_label, line->name, line->is_used != 0});
        },
        &seen.lines);
    return seen;
}

std::vector<seen_line> lines_called(const std::vector<seen_line> &all, const std::string &name,
                                    const std::string &chip)
{
    std::vector<seen_line> called;
    std::copy_if(all.begin(), all.end(), std::back_inserter(called), [&](const seen_line &line) {
        return line.name == name && (chip.empty() || chip == line.chip || chip == line.chip_label);
    });
    return called;
}

std::string that_is_ambiguous(const std::vector<seen_line> &called)
{
    if (called.size() < 2) {
        return "";
    }
    std::string chips;
    bool is_one_chip = true;
    for (std::size_t i = 0; i < called.size(); i++) {
        chips += (i == 0 ? "" : i + 1 == called.size() ? " and " : ", ") + called[i].chip;
        is_one_chip = is_one_chip && called[i].chip == called.front().chip;
    }
    if (is_one_chip) {
        return called.front().name + " names " + std::to_string(called.size()) + " lines of " + called.front().chip +
               "; give one of them another name (gpio-line-names in the device tree)";
    }
    return called.front().name + " is on " + chips +
           "; name the chip in target.gpio_chip, by its name or by a label "
           "that no other chip has";
}

lines::lines(const target_rig &target)
{
    const std::vector<seen_line> seen = lines_of_machine().lines;
    std::size_t number = 0;
    for (const line_wiring &wiring : wiring_of(target)) {
        if (!wiring.name.empty()) {
            const std::string ambiguous = that_is_ambiguous(lines_called(seen, wiring.name, target.gpio_chip));
            if (!ambiguous.empty()) { /* none is taken by chance: it may stop the robot */
                throw hardware_error(std::string(wiring.key) + ": " + ambiguous);
            }
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
    gpio_line *const wire = of(line);
    if (wire != nullptr) {
        outputs_[static_cast<std::size_t>(line)].set(level, [=](int value) { return gpio_line_set(wire, value); });
    }
}

bool lines::next_edge(rig_line line, gpio_edge &edge) const
{
    return of(line) != nullptr && gpio_line_next_edge(of(line), &edge) == 1;
}

} // namespace berth
