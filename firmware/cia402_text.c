#include "cia402_text.h"

#include <stdarg.h>
#include <stdio.h>

struct abort_row {
    uint32_t code;
    const char *text;
};

/* CiA 301, SDO abort codes. */
static const struct abort_row abort_rows[] = {
    {0x05030000, "toggle bit not alternated"},
    {0x05040000, "SDO protocol timed out"},
    {0x05040001, "SDO command not known"},
    {0x05040002, "invalid block size"},
    {0x05040003, "invalid sequence number"},
    {0x05040004, "CRC error"},
    {0x05040005, "out of memory"},
    {0x06010000, "access to the object is not supported"},
    {0x06010001, "the object is write only"},
    {0x06010002, "the object is read only"},
    {0x06020000, "the object does not exist"},
    {0x06040041, "the object cannot be mapped into a PDO"},
    {0x06040042, "the mapped objects exceed the length of a PDO"},
    {0x06040043, "parameters do not go together"},
    {0x06040047, "the device does not go together with it"},
    {0x06060000, "hardware error"},
    {0x06070010, "the length does not match the object"},
    {0x06070012, "the length is too long for the object"},
    {0x06070013, "the length is too short for the object"},
    {0x06090011, "the subindex does not exist"},
    {0x06090030, "the value is invalid"},
    {0x06090031, "the value is too high"},
    {0x06090032, "the value is too low"},
    {0x06090036, "the maximum is less than the minimum"},
    {0x060a0023, "resource not available"},
    {0x08000000, "general error"},
    {0x08000020, "data cannot be stored"},
    {0x08000021, "data cannot be stored: local control"},
    {0x08000022, "data cannot be stored in this state of the device"},
    {0x08000023, "no object dictionary"},
    {0x08000024, "no data available"},
};

const char *canopen_abort_text(uint32_t code)
{
    for (size_t i = 0; i < sizeof abort_rows / sizeof abort_rows[0]; i++) {
        if (abort_rows[i].code == code) {
            return abort_rows[i].text;
        }
    }
    return "a code of the maker's own";
}

/* Text that is too long ends early. */
static void append(char text[CIA402_TEXT_BYTES_MAX], size_t *used, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int size = vsnprintf(text + *used, CIA402_TEXT_BYTES_MAX - *used, format, arguments);
    va_end(arguments);
    *used += size < 0 ? 0 : (size_t)size;
    *used = *used < CIA402_TEXT_BYTES_MAX ? *used : CIA402_TEXT_BYTES_MAX - 1;
}

static double units_a_second(int8_t index)
{
    double units = 1.0;
    for (int8_t i = index; i < 0; i++) {
        units *= 10.0;
    }
    return units;
}

/* The rates that a drive can take whose own period is value * 10^index s. */
static void append_rates(char text[CIA402_TEXT_BYTES_MAX], size_t *used, uint32_t error)
{
    const unsigned value = error >> 8 & 0xffu;
    const int8_t index = (int8_t)(error & 0xffu);
    if (index > 0 || index < -9) {
        append(text, used, "; its index is %d, which makes no period of a loop", index);
    } else if (value != 0) {
        append(text, used, "; it keeps %u * 10^%d s: set loop.rate_Hz = %.10g", value, index,
               units_a_second(index) / value);
    } else {
        append(
            text, used,
            "; its unit is 10^%d s, of which it takes 1 to 255: set loop.rate_Hz to %.10g divided by such a whole "
            "number",
            index, units_a_second(index));
    }
}

struct loss_row {
    uint16_t object;
    const char *text;
};

/* What a drive that refuses an object cannot do. */
static const struct loss_row loss_rows[] = {
    {0x100c, "it has neither heartbeat (0x1017) nor node guarding, so nobody would see that it has gone"},
    {0x1400, "it takes no setpoint with SYNC"},
    {0x1800, "it reports no position with SYNC"},
    {0x6060, "it has no cyclic synchronous position"},
    {0x607e,
     "the sign of its positions cannot be set: set it with the maker's tool, and cia402.polarity to as_it_is"},
    {0x608f, "set it with the maker's tool, and cia402.encoder_counts to 0"},
    {0x6091, "set it with the maker's tool, and cia402.gear_motor_revolutions to 0"},
    {0x6092, "set it with the maker's tool, and cia402.feed_counts to 0"},
    {0x6098, "it does not do this homing: home it with the maker's tool, and set cia402.homing_method to 0"},
    {0x60c2, "it does not know how far apart the setpoints are"},
};

static void append_loss(char text[CIA402_TEXT_BYTES_MAX], size_t *used, uint32_t object)
{
    for (size_t i = 0; i < sizeof loss_rows / sizeof loss_rows[0]; i++) {
        if (loss_rows[i].object == object >> 8) {
            append(text, used, "; %s", loss_rows[i].text);
        }
    }
}

static void append_wrong_value(char text[CIA402_TEXT_BYTES_MAX], size_t *used, uint32_t setup_step, uint32_t value)
{
    append(text, used, "; it holds 0x%X", value);
    if (setup_step < cia402_all_steps && cia402_steps[setup_step].configured == NULL) {
        append(text, used, ", of which the bits 0x%X have to be 0x%X", cia402_steps[setup_step].mask,
               cia402_steps[setup_step].value);
    }
}

void cia402_trouble_text(enum cia402_trouble trouble, uint32_t setup_step, uint32_t error,
                         char text[CIA402_TEXT_BYTES_MAX])
{
    size_t used = 0;
    text[0] = '\0';
    if (trouble == DRIVE_TROUBLE_NONE) {
        return;
    }
    append(text, &used, "%s", cia402_trouble_name(trouble));
    const uint32_t object = cia402_setup_object(setup_step);
    if (object != 0) {
        append(text, &used, ", object 0x%04X:%02X", object >> 8, object & 0xffu);
    }
    switch (trouble) {
    case DRIVE_TROUBLE_SDO_ABORT:
        append(text, &used, ", SDO abort code 0x%08X (%s)", error, canopen_abort_text(error));
        append_loss(text, &used, object);
        break;
    case DRIVE_TROUBLE_WRONG_VALUE:
        append_wrong_value(text, &used, setup_step, error);
        break;
    case DRIVE_TROUBLE_HOMING:
        append(text, &used, ", or the enable line was taken away while it moved");
        break;
    case DRIVE_TROUBLE_NO_PERIOD:
        append_rates(text, &used, error);
        break;
    case DRIVE_TROUBLE_UNWATCHED:
        append(text, &used,
               "; cia402.must_watch_loop = false lets it be: then the drive must have another way to stop");
        break;
    default:
        if (error != 0) {
            append(text, &used, ", EMCY error code 0x%04X", error);
        }
        break;
    }
}
