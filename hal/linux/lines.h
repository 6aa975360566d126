/* The five lines of [target], or none of them. */
#ifndef HAL_LINUX_LINES_H
#define HAL_LINUX_LINES_H

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "../rig/rig.h"
#include "gpio_lines.h"
#include "output_level.h"

namespace berth
{

enum class rig_line { emergency_stop, enable, heartbeat, tick, fault };
constexpr std::size_t rig_line_count = 5;

/* What a line is called in the rig, and what it is. */
struct line_wiring {
    const char *key;
    std::string name; /* empty: not wired */
    gpio_direction direction;
    bool is_active_low;
};

std::array<line_wiring, rig_line_count> wiring_of(const target_rig &target);

/* A line of this machine. */
struct seen_line {
    std::string chip;       /* as "gpiochip0" */
    std::string chip_label; /* the driver's word for it */
    std::string name;
    bool is_used;
};

struct seen_lines {
    int chips;
    std::vector<seen_line> lines;
};
seen_lines lines_of_machine();

/* Those that go by this name on `chip`: a name or a label; empty: any. */
std::vector<seen_line> lines_called(const std::vector<seen_line> &all, const std::string &name,
                                    const std::string &chip);

/* Linux lets several lines have one name. What to do then; empty: there is at most one. */
std::string that_is_ambiguous(const std::vector<seen_line> &called);

class lines
{
  public:
    /* Throws hardware_error. */
    explicit lines(const target_rig &target);

    bool is_wired(rig_line line) const { return of(line) != nullptr; }

    /* `level_if_broken` where the line cannot be read. */
    std::uint8_t get(rig_line line, std::uint8_t level_if_broken) const;

    /* Costs a system call only where the level changes; a write that failed is repeated at the next call. */
    void set(rig_line line, std::uint8_t level);

    bool next_edge(rig_line line, gpio_edge &edge) const;

  private:
    struct closer {
        void operator()(gpio_line *line) const { gpio_line_close(line); }
    };

    gpio_line *of(rig_line line) const { return lines_[static_cast<std::size_t>(line)].get(); }

    std::array<std::unique_ptr<gpio_line, closer>, rig_line_count> lines_;
    std::array<output_level, rig_line_count> outputs_;
};

} // namespace berth

#endif
