/* libgpiod 2.x, as in Debian 13. */
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <gpiod.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gpio_lines.h"

struct gpio_line {
    struct gpiod_line_request *request;
    struct gpiod_edge_event_buffer *edges; /* NULL: none are asked for */
    unsigned offset;
};

/* Opens the chips one after another until `use` has found what it wants. */
static int for_each_chip(int (*use)(void *context, struct gpiod_chip *chip), void *context)
{
    int chips = 0;
    glob_t paths;
    if (glob("/dev/gpiochip*", 0, NULL, &paths) != 0) {
        return 0;
    }
    for (size_t i = 0; i < paths.gl_pathc; i++) {
        struct gpiod_chip *chip = gpiod_chip_open(paths.gl_pathv[i]);
        if (chip != NULL) {
            chips++;
            const int is_done = use(context, chip);
            gpiod_chip_close(chip);
            if (is_done) {
                break;
            }
        }
    }
    globfree(&paths);
    return chips;
}

struct wanted_line {
    const char *chip_name; /* empty: any */
    const char *name;
    enum gpio_direction direction;
    int active_low;
    int is_found;
    unsigned offset;
    struct gpiod_line_request *request;
};

static int is_chip(struct gpiod_chip *chip, const char *name)
{
    struct gpiod_chip_info *info = gpiod_chip_get_info(chip);
    const int is_it = info != NULL && (strcmp(gpiod_chip_info_get_name(info), name) == 0 ||
                                       strcmp(gpiod_chip_info_get_label(info), name) == 0);
    gpiod_chip_info_free(info);
    return is_it;
}

static struct gpiod_line_request *request(struct gpiod_chip *chip, const struct wanted_line *wanted)
{
    struct gpiod_line_request *request = NULL;
    struct gpiod_line_settings *settings = gpiod_line_settings_new();
    struct gpiod_line_config *lines = gpiod_line_config_new();
    struct gpiod_request_config *consumer = gpiod_request_config_new();
    if (settings != NULL && lines != NULL && consumer != NULL) {
        gpiod_line_settings_set_direction(settings, wanted->direction == GPIO_OUT ? GPIOD_LINE_DIRECTION_OUTPUT
                                                                                  : GPIOD_LINE_DIRECTION_INPUT);
        gpiod_line_settings_set_active_low(settings, wanted->active_low);
        if (wanted->direction == GPIO_IN_WITH_EDGES) {
            gpiod_line_settings_set_edge_detection(settings, GPIOD_LINE_EDGE_BOTH);
            gpiod_line_settings_set_event_clock(settings, GPIOD_LINE_CLOCK_MONOTONIC);
        }
        gpiod_request_config_set_consumer(consumer, GPIO_CONSUMER);
        if (gpiod_line_config_add_line_settings(lines, &wanted->offset, 1, settings) == 0) {
            request = gpiod_chip_request_lines(chip, consumer, lines);
        }
    }
    gpiod_request_config_free(consumer);
    gpiod_line_config_free(lines);
    gpiod_line_settings_free(settings);
    return request;
}

static int find_and_request(void *context, struct gpiod_chip *chip)
{
    struct wanted_line *wanted = context;
    if (wanted->chip_name[0] != '\0' && !is_chip(chip, wanted->chip_name)) {
        return 0;
    }
    const int offset = gpiod_chip_get_line_offset_from_name(chip, wanted->name);
    if (offset < 0) {
        return 0;
    }
    wanted->is_found = 1;
    wanted->offset = (unsigned)offset;
    wanted->request = request(chip, wanted);
    return 1;
}

struct gpio_line *gpio_line_open(const char *chip, const char *name, enum gpio_direction direction, int active_low,
                                 char *error, size_t error_bytes)
{
    struct wanted_line wanted = {.chip_name = chip, .name = name, .direction = direction, .active_low = active_low};
    for_each_chip(find_and_request, &wanted);
    if (!wanted.is_found) {
        snprintf(error, error_bytes, "no GPIO line is called \"%s\"; `gpioinfo` lists names", name);
        return NULL;
    }
    if (wanted.request == NULL) {
        snprintf(error, error_bytes, "GPIO line \"%s\" cannot be had (%s); does another program hold it?", name,
                 strerror(errno));
        return NULL;
    }
    struct gpio_line *line = calloc(1, sizeof *line);
    if (line == NULL) {
        abort();
    }
    line->request = wanted.request;
    line->offset = wanted.offset;
    if (direction == GPIO_IN_WITH_EDGES) {
        const int file = gpiod_line_request_get_fd(line->request);
        fcntl(file, F_SETFL, fcntl(file, F_GETFL) | O_NONBLOCK);
        line->edges = gpiod_edge_event_buffer_new(1);
    }
    return line;
}

void gpio_line_close(struct gpio_line *line)
{
    if (line != NULL) {
        gpiod_edge_event_buffer_free(line->edges);
        gpiod_line_request_release(line->request);
        free(line);
    }
}

int gpio_line_get(struct gpio_line *line)
{
    const enum gpiod_line_value value = gpiod_line_request_get_value(line->request, line->offset);
    return value == GPIOD_LINE_VALUE_ERROR ? -1 : value == GPIOD_LINE_VALUE_ACTIVE;
}

int gpio_line_set(struct gpio_line *line, int level)
{
    return gpiod_line_request_set_value(line->request, line->offset,
                                        level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE);
}

int gpio_line_next_edge(struct gpio_line *line, struct gpio_edge *edge)
{
    if (line->edges == NULL || gpiod_line_request_read_edge_events(line->request, line->edges, 1) != 1) {
        return 0;
    }
    struct gpiod_edge_event *event = gpiod_edge_event_buffer_get_event(line->edges, 0);
    edge->time_ns = (int64_t)gpiod_edge_event_get_timestamp_ns(event);
    edge->level = gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE;
    return 1;
}

struct visitor {
    void (*visit)(void *context, const struct gpio_seen_line *line);
    void *context;
};

static int visit_chip(void *context, struct gpiod_chip *chip)
{
    const struct visitor *visitor = context;
    struct gpiod_chip_info *chip_info = gpiod_chip_get_info(chip);
    if (chip_info == NULL) {
        return 0;
    }
    for (unsigned offset = 0; offset < gpiod_chip_info_get_num_lines(chip_info); offset++) {
        struct gpiod_line_info *line = gpiod_chip_get_line_info(chip, offset);
        if (line != NULL) {
            const char *name = gpiod_line_info_get_name(line);
            const struct gpio_seen_line seen = {gpiod_chip_info_get_name(chip_info),
                                                gpiod_chip_info_get_label(chip_info), name != NULL ? name : "",
                                                gpiod_line_info_is_used(line)};
            visitor->visit(visitor->context, &seen);
            gpiod_line_info_free(line);
        }
    }
    gpiod_chip_info_free(chip_info);
    return 0;
}

int gpio_for_each_line(void (*visit)(void *context, const struct gpio_seen_line *line), void *context)
{
    struct visitor visitor = {visit, context};
    return for_each_chip(visit_chip, &visitor);
}

const char *gpio_library_version(void)
{
    return gpiod_api_version();
}
