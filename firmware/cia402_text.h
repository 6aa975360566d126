/* What is wrong with a CiA 402 drive, in a sentence: for the end of a run, never in a tick. */
#ifndef FIRMWARE_CIA402_TEXT_H
#define FIRMWARE_CIA402_TEXT_H

#include <stddef.h>
#include <stdint.h>

#include "cia402.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What an SDO abort code of CiA 301 says; "a code of the maker's own" for others. */
const char *canopen_abort_text(uint32_t code);

#define CIA402_TEXT_BYTES_MAX 320

/* Trouble, object and error as the tick's record has them (drive_trouble, drive_setup_step, drive_error), and what
 * to do where that is known. Empty without trouble. */
void cia402_trouble_text(enum cia402_trouble trouble, uint32_t setup_step, uint32_t error,
                         char text[CIA402_TEXT_BYTES_MAX]);

#ifdef __cplusplus
}
#endif
#endif
