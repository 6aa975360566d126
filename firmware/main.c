/* The loop on its own: the same program against the simulated rig and on the target. */
#include <stdio.h>

#include "cia402_text.h"
#include "loop.h"

enum exit_code { EXIT_DONE = 0, EXIT_USAGE_OR_INPUT = 2, EXIT_HARDWARE = 3 };

static enum exit_code exit_code_of(enum hal_status status)
{
    switch (status) {
    case HAL_OK:
    case HAL_END:
        return EXIT_DONE;
    case HAL_INVALID:
        return EXIT_USAGE_OR_INPUT;
    default:
        return EXIT_HARDWARE;
    }
}

int main(int argc, char **argv)
{
    static struct app app; /* large, and static keeps it off the stack */
    struct app_config config;
    struct hal *hal = NULL;

    enum hal_status status = hal_open(&hal, argc, argv, &config);
    if (status != HAL_OK) {
        return exit_code_of(status);
    }
    app_start(&app, &config);
    status = loop_run(hal, &app);
    const enum hal_status closed = hal_close(hal);

    printf("%s: %lld ticks, %u not recorded, %u frames not sent\n", supervisor_state_name(app.supervisor.state),
           (long long)app.recorder.tick.index + 1, app.unrecorded_ticks, app.unsent_frames);
    if (app.supervisor.stop_cause != STOP_NONE) {
        printf("stopped because: %s\n", stop_cause_name(app.supervisor.stop_cause));
    }
    const struct cia402 *drive = &app.robot_channel.drive;
    if (drive->trouble != DRIVE_TROUBLE_NONE) {
        char text[CIA402_TEXT_BYTES_MAX];
        cia402_trouble_text((enum cia402_trouble)drive->trouble, drive->setup.step, drive->error, text);
        printf("drive: %s\n", text);
    }
    return exit_code_of(status == HAL_END ? closed : status);
}
