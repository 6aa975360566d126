/* Every input and every output of every tick, as ULog messages (PX4's log format, version 1) that PlotJuggler,
 * Foxglove and pyulog read. One list of fields makes the record, its description in the log, and the comparison
 * of a replay. The unit is the last part of a field's name. */
#ifndef FIRMWARE_RECORDER_H
#define FIRMWARE_RECORDER_H

#include "arm/arm_record.h"
#include "side_record.h"
#include "types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One a tick. Large fields first: no padding. Inputs: index to emergency_stop, unsent_frames (and the frames); the
 * rest are outputs. `timestamp` is in us, as ULog wants it. energy_*: see energy_account.h; believed_*:
 * prediction.h. drive_*: profile "cia402", else 0; drive_error: SDO abort code, EMCY error code or the value
 * that the drive holds, drive_trouble says which. */
#define TICK_RECORD_FIELDS(X)                                                                                       \
    X(uint64_t, timestamp)                                                                                          \
    X(int64_t, index)                                                                                               \
    X(int64_t, scheduled_ns)                                                                                        \
    X(int64_t, woke_ns)                                                                                             \
    X(int64_t, force_frame_age_ns)                                                                                  \
    X(double, operator_position_m)                                                                                  \
    X(double, operator_velocity_m_per_s)                                                                            \
    X(double, operator_force_N)                                                                                     \
    X(double, force_N)                                                                                              \
    X(double, used_force_N)                                                                                         \
    X(double, manipulator_position_m)                                                                               \
    X(double, manipulator_velocity_m_per_s)                                                                         \
    X(double, displayed_position_m)                                                                                 \
    X(double, filtered_position_m)                                                                                  \
    X(double, command_position_m)                                                                                   \
    X(double, robot_position_m)                                                                                     \
    X(double, energy_stored_J)                                                                                      \
    X(double, energy_operator_J)                                                                                    \
    X(double, energy_dissipated_J)                                                                                  \
    X(double, energy_integrator_J)                                                                                  \
    X(double, energy_simulated_port_J)                                                                              \
    X(double, energy_measured_port_J)                                                                               \
    X(double, energy_dead_time_J)                                                                                   \
    X(double, energy_compensation_J)                                                                                \
    X(double, predicted_error_N)                                                                                    \
    X(double, inverse_gain)                                                                                         \
    X(double, inverse_delay_s)                                                                                      \
    X(double, inverse_curve_s2)                                                                                     \
    X(double, inverse_error_m)                                                                                      \
    X(double, lead_error_N)                                                                                         \
    X(double, passivity_deficit_J)                                                                                  \
    X(double, passivity_force_N)                                                                                    \
    X(float, believed_mass_kg)                                                                                      \
    X(float, believed_damping_N_s_per_m)                                                                            \
    X(float, believed_stiffness_N_per_m)                                                                            \
    X(float, believed_dead_time_ms)                                                                                 \
    X(uint32_t, missed_ticks)                                                                                       \
    X(uint32_t, rejected_frames)                                                                                    \
    X(uint32_t, old_frames)                                                                                         \
    X(uint32_t, lost_frames)                                                                                        \
    X(uint32_t, force_samples)                                                                                      \
    X(uint32_t, torn_samples)                                                                                       \
    X(uint32_t, error_frames)                                                                                       \
    X(uint32_t, unsent_frames)                                                                                      \
    X(uint32_t, saturated_setpoints)                                                                                \
    X(uint32_t, conditions)                                                                                         \
    X(uint32_t, drive_error)                                                                                        \
    X(uint16_t, drive_statusword)                                                                                   \
    X(uint8_t, drive_trouble)                                                                                       \
    X(uint8_t, drive_setup_step)                                                                                    \
    X(uint8_t, enable)                                                                                              \
    X(uint8_t, emergency_stop)                                                                                      \
    X(uint8_t, stop)                                                                                                \
    X(uint8_t, state)                                                                                               \
    X(uint8_t, stop_cause)                                                                                          \
    X(uint8_t, limits)                                                                                              \
    X(uint8_t, operator_request)                                                                                    \
    X(uint8_t, heartbeat)

#define RECORD_MEMBER(type, name) type name;
struct tick_record {
    TICK_RECORD_FIELDS(RECORD_MEMBER)
};

/* One a frame, in the order in which the loop took or sent it; `direction` 0 received, 1 sent. */
#define FRAME_RECORD_FIELDS(X)                                                                                      \
    X(uint64_t, timestamp)                                                                                          \
    X(int64_t, time_ns)                                                                                             \
    X(uint64_t, data)                                                                                               \
    X(uint32_t, id)                                                                                                 \
    X(uint8_t, bus)                                                                                                 \
    X(uint8_t, length)                                                                                              \
    X(uint8_t, flags)                                                                                               \
    X(uint8_t, direction)

struct frame_record {
    FRAME_RECORD_FIELDS(RECORD_MEMBER)
};

#define ULOG_TICK_ID 0
#define ULOG_FRAME_ID 1
#define ULOG_ARM_ID 4 /* 2 and 3 are the HALs' own */
#define ULOG_SIDE_ID 5

/* A ULog data message: size, type 'D', message id, then the record as it lies in memory (little-endian). */
#define ULOG_DATA_HEADER_BYTES 5
#define RECORDER_BEFORE_BYTES_MAX                                                                                   \
    ((TICK_FRAMES_IN_MAX + TICK_FRAMES_OUT_MAX) * (ULOG_DATA_HEADER_BYTES + sizeof(struct frame_record)) +          \
     ULOG_DATA_HEADER_BYTES + sizeof(struct arm_record) + ULOG_DATA_HEADER_BYTES + sizeof(struct side_record) +     \
     ULOG_DATA_HEADER_BYTES)
#define RECORDER_TICK_BYTES_MAX (RECORDER_BEFORE_BYTES_MAX + sizeof(struct tick_record))

/* The messages of one tick: frames received, frames sent, the arm and the robot's further axes, if there are, then
 * the tick itself. Its record is made where its message stands, so that nobody has to copy it. */
struct recorder {
    uint8_t before[(RECORDER_BEFORE_BYTES_MAX + 7) / 8 * 8]; /* the messages end where `tick` begins */
    struct tick_record tick;
    const uint8_t *bytes; /* of the messages, within this struct */
    uint32_t size_bytes;
};

/* Replaces the messages before `tick`, which has been filled in, by those of its tick. `arm`, `side`: NULL if there
 * is none. */
void recorder_write(struct recorder *recorder, const struct tick_input *in, const struct tick_output *out,
                    const struct arm_record *arm, const struct side_record *side);

/* ULog format strings "name:type field;..." of the records. */
extern const char *const tick_record_format;
extern const char *const arm_record_format;
extern const char *const side_record_format;
extern const char *const frame_record_format;

#ifdef __cplusplus
}
#endif
#endif
