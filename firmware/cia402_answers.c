#include <stddef.h>

#include "canopen.h"
#include "cia402_setup.h"

/* The value in an answer to a read: of the bytes that it says to have, or, where it says nothing, of the object's.
 */
static uint32_t expedited_value(const struct setup_step *step, const uint8_t data[8])
{
    const uint32_t given = (data[0] & SDO_SIZE_IS_TOLD) != 0 ? 4u - (data[0] >> 2 & 3u) : step->length;
    return canopen_get(data + 4, given < step->length ? given : step->length);
}

static int take_value(struct cia402_setup *setup, uint32_t value)
{
    setup->answer_value = value;
    setup->has_answer = 1;
    return 1;
}

/* A segment with all of the object, as an object of up to seven bytes needs no other. It names no object. */
static int receive_segment(struct cia402_setup *setup, const struct setup_step *step, const uint8_t data[8])
{
    const uint32_t given = 7u - (data[0] >> 1 & 7u);
    if ((data[0] & ~SDO_SEGMENT_SIZE) != SDO_LAST_SEGMENT) {
        setup->is_strange = 1;
        return 0;
    }
    setup->segment = SEGMENT_NONE;
    return take_value(setup, canopen_get(data + 1, given < step->length ? given : step->length));
}

int cia402_setup_receive(struct cia402_setup *setup, const uint8_t data[8])
{
    const uint8_t service = data[0] & SDO_SERVICE;
    if (setup->is_homing && service == SDO_DOWNLOADED && canopen_get(data + 1, 2) == 0x6040 && setup->is_stopping) {
        setup->is_homing = 0;
        setup->is_stopping = 0;
        return 1;
    }
    if (cia402_setup_is_whole(setup) || setup->trouble != SETUP_FINE || setup->in_flight_ticks == 0 ||
        setup->has_answer) {
        return 0;
    }
    const struct setup_step *step = &cia402_steps[setup->step];
    if (setup->segment == SEGMENT_ASKED && service == SDO_SEGMENT) {
        return receive_segment(setup, step, data);
    }
    if (!cia402_step_is_sdo(step) || canopen_get(data + 1, 2) != cia402_setup_index(setup, step) ||
        data[3] != step->subindex) {
        return 0;
    }
    if (data[0] == SDO_ABORT) {
        setup->abort_code = canopen_get(data + 4, 4);
        return take_value(setup, 0);
    }
    if (!cia402_step_is_read(step) && service == SDO_DOWNLOADED) {
        return take_value(setup, 0);
    }
    if (cia402_step_is_read(step) && service == SDO_UPLOAD_ANSWER && (data[0] & SDO_IS_EXPEDITED) != 0) {
        return take_value(setup, expedited_value(step, data));
    }
    if (cia402_step_is_read(step) && service == SDO_UPLOAD_ANSWER && setup->segment == SEGMENT_NONE) {
        setup->segment = SEGMENT_DUE;
        return 1;
    }
    setup->is_strange = 1;
    return 0;
}
