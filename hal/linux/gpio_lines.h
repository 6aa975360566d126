/* The rig's lines, by name, through libgpiod: gpio_v1.c or gpio_v2.c, whichever fits the library that is there.
 * Software GPIO is not the safety function of a rig: the emergency stop must cut the power by itself. */
#ifndef HAL_LINUX_GPIO_LINES_H
#define HAL_LINUX_GPIO_LINES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct gpio_line;

enum gpio_direction { GPIO_IN, GPIO_IN_WITH_EDGES, GPIO_OUT };

struct gpio_edge {
    int64_t time_ns; /* by the kernel, CLOCK_MONOTONIC */
    int level;       /* after the edge, positive logic */
};

/* Finds the line called `name` on `chip` (by name, as "gpiochip0", or label; empty: on all chips) and takes it for
 * `consumer`. Outputs start at 0. NULL: `error` says why, and what to do. */
struct gpio_line *gpio_line_open(const char *chip, const char *name, enum gpio_direction direction, int active_low,
                                 char *error, size_t error_bytes);
void gpio_line_close(struct gpio_line *line);

/* 0 or 1; negative: the line cannot be read. */
int gpio_line_get(struct gpio_line *line);

/* Negative: the line cannot be set. */
int gpio_line_set(struct gpio_line *line, int level);

/* Takes the oldest edge that has been seen. 1, or 0 if there is none. Never blocks. */
int gpio_line_next_edge(struct gpio_line *line, struct gpio_edge *edge);

struct gpio_seen_line {
    const char *chip;       /* as "gpiochip0" */
    const char *chip_label; /* the driver's word for it; stays the same from boot to boot */
    const char *name;       /* may be empty */
    int is_used;
};

/* Calls `visit` for each line of each chip. Returns the number of chips. */
int gpio_for_each_line(void (*visit)(void *context, const struct gpio_seen_line *line), void *context);

/* As "1.6.3". */
const char *gpio_library_version(void);

#define GPIO_CONSUMER "berth"

#ifdef __cplusplus
}
#endif
#endif
