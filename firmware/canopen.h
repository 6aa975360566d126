/* CANopen as far as a master of one node needs it: identifiers of the predefined connection set, codes of its
 * services, numbers in frames. Source: CiA 301 (application layer). */
#ifndef FIRMWARE_CANOPEN_H
#define FIRMWARE_CANOPEN_H

#include <stdint.h>

/* Identifiers; to those of a node its number is added. */
#define CANOPEN_NMT_ID 0x000
#define CANOPEN_SYNC_ID 0x080
#define CANOPEN_EMERGENCY_ID 0x080 /* + node */
#define CANOPEN_TPDO1_ID 0x180     /* + node: what the node sends */
#define CANOPEN_RPDO1_ID 0x200     /* + node: what it receives */
#define CANOPEN_SDO_ANSWER_ID 0x580
#define CANOPEN_SDO_REQUEST_ID 0x600
#define CANOPEN_HEARTBEAT_ID 0x700

#define CANOPEN_NODE_ID_MAX 127

/* Node guarding: a node answers a remote frame of its heartbeat's identifier with its state and this bit, which is 0
 * in the first answer after booting and changes with each. */
#define CANOPEN_GUARD_TOGGLE 0x80u

enum canopen_nmt_command {
    NMT_COMMAND_START = 0x01,
    NMT_COMMAND_RESET_COMMUNICATION = 0x82,
};

/* As a heartbeat tells it. */
enum canopen_nmt_state {
    NMT_STATE_BOOT_UP = 0x00,
    NMT_STATE_STOPPED = 0x04,
    NMT_STATE_OPERATIONAL = 0x05,
    NMT_STATE_PRE_OPERATIONAL = 0x7f,
};

/* First byte of an SDO frame. Expedited: up to 4 bytes of data in the frame itself, their number in bits 2 and 3. */
enum canopen_sdo {
    SDO_DOWNLOAD = 0x23, /* with 4 bytes; 4 more for each byte less */
    SDO_DOWNLOADED = 0x60,
    SDO_UPLOAD = 0x40,
    SDO_UPLOADED = 0x43, /* as SDO_DOWNLOAD */
    SDO_ASK_SEGMENT = 0x60,
    SDO_ABORT = 0x80,
};

/* Its parts, in answers: which service, in the three highest bits; then those of reads. */
#define SDO_SERVICE 0xe0u
#define SDO_SEGMENT 0x00u
#define SDO_UPLOAD_ANSWER 0x40u
#define SDO_IS_EXPEDITED 0x02u /* the data are in the frame; else they come in segments */
#define SDO_SIZE_IS_TOLD 0x01u
#define SDO_LAST_SEGMENT 0x01u /* and the first: its toggle bit is 0 */
#define SDO_SEGMENT_SIZE 0x0eu

#define SDO_ABORT_TIMEOUT 0x05040000u
#define SDO_ABORT_NO_OBJECT 0x06020000u
#define SDO_ABORT_NO_SUBINDEX 0x06090011u

/* In COB-ID entries of PDO parameters. */
#define CANOPEN_PDO_DISABLED 0x80000000u
#define CANOPEN_PDO_NO_REMOTE 0x40000000u
#define CANOPEN_PDO_EVERY_SYNC 1u /* transmission type: synchronous, with each SYNC */

/* Little-endian numbers. */
static inline void canopen_put(uint8_t *to, uint32_t value, uint32_t bytes)
{
    for (uint32_t i = 0; i < bytes; i++) {
        to[i] = (uint8_t)(value >> (8u * i));
    }
}

static inline uint32_t canopen_get(const uint8_t *from, uint32_t bytes)
{
    uint32_t value = 0;
    for (uint32_t i = 0; i < bytes; i++) {
        value |= (uint32_t)from[i] << (8u * i);
    }
    return value;
}

#endif
