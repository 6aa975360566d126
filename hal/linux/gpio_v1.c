/* libgpiod 1.x, as in Debian 12. */
#include <errno.h>
#include <fcntl.h>
#include <gpiod.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gpio_lines.h"

struct gpio_line {
    struct gpiod_chip *chip;
    struct gpiod_line *line;
    int event_file; /* -1: no edges */
};

static struct gpiod_line *find_line(const char *chip_name, const char *name, struct gpiod_chip **chip)
{
    struct gpiod_line *line;
    if (chip_name[0] == '\0') {
        line = gpiod_line_find(name);
        *chip = line != NULL ? gpiod_line_get_chip(line) : NULL;
        return line;
    }
    *chip = gpiod_chip_open_lookup(chip_name);
    line = *chip != NULL ? gpiod_chip_find_line(*chip, name) : NULL;
    if (line == NULL && *chip != NULL) {
        gpiod_chip_close(*chip);
    }
    return line;
}

static int request(struct gpio_line *line, enum gpio_direction direction, int active_low)
{
    const int flags = active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
    if (direction == GPIO_OUT) {
        return gpiod_line_request_output_flags(line->line, GPIO_CONSUMER, flags, 0);
    }
    if (direction == GPIO_IN) {
        return gpiod_line_request_input_flags(line->line, GPIO_CONSUMER, flags);
    }
    const int status = gpiod_line_request_both_edges_events_flags(line->line, GPIO_CONSUMER, flags);
    if (status == 0) {
        line->event_file = gpiod_line_event_get_fd(line->line);
        return fcntl(line->event_file, F_SETFL, fcntl(line->event_file, F_GETFL) | O_NONBLOCK);
    }
    return status;
}

struct gpio_line *gpio_line_open(const char *chip, const char *name, enum gpio_direction direction, int active_low,
                                 char *error, size_t error_bytes)
{
    struct gpio_line found = {.event_file = -1};
    found.line = find_line(chip, name, &found.chip);
    if (found.line == NULL) {
        snprintf(error, error_bytes, "no GPIO line is called \"%s\"; `gpioinfo` lists names", name);
        return NULL;
    }
    if (request(&found, direction, active_low) != 0) {
        snprintf(error, error_bytes, "GPIO line \"%s\" cannot be had (%s); does another program hold it?", name,
                 strerror(errno));
        gpiod_chip_close(found.chip);
        return NULL;
    }
    struct gpio_line *line = malloc(sizeof *line);
    if (line == NULL) {
        abort();
    }
    *line = found;
    return line;
}

void gpio_line_close(struct gpio_line *line)
{
    if (line != NULL) {
        gpiod_line_release(line->line);
        gpiod_chip_close(line->chip);
        free(line);
    }
}

int gpio_line_get(struct gpio_line *line)
{
    return gpiod_line_get_value(line->line);
}

int gpio_line_set(struct gpio_line *line, int level)
{
    return gpiod_line_set_value(line->line, level);
}

int gpio_line_next_edge(struct gpio_line *line, struct gpio_edge *edge)
{
    struct gpiod_line_event event;
    if (line->event_file < 0 || gpiod_line_event_read_fd(line->event_file, &event) != 0) {
        return 0;
    }
    edge->time_ns = (int64_t)event.ts.tv_sec * 1000000000 + event.ts.tv_nsec;
    edge->level = event.event_type == GPIOD_LINE_EVENT_RISING_EDGE;
    return 1;
}

int gpio_for_each_line(void (*visit)(void *context, const struct gpio_seen_line *line), void *context)
{
    int chips = 0;
    struct gpiod_chip_iter *chip_iterator = gpiod_chip_iter_new();
    if (chip_iterator == NULL) {
        return 0;
    }
    for (struct gpiod_chip *chip; (chip = gpiod_chip_iter_next(chip_iterator)) != NULL; chips++) {
        for (unsigned offset = 0; offset < gpiod_chip_num_lines(chip); offset++) {
            struct gpiod_line *line = gpiod_chip_get_line(chip, offset);
            if (line != NULL) {
                const char *name = gpiod_line_name(line);
                const struct gpio_seen_line seen = {gpiod_chip_name(chip), gpiod_chip_label(chip),
                                                    name != NULL ? name : "", gpiod_line_is_used(line)};
                visit(context, &seen);
            }
        }
    }
    gpiod_chip_iter_free(chip_iterator);
    return chips;
}

const char *gpio_library_version(void)
{
    return gpiod_version_string();
}
