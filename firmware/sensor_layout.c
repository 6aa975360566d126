#include "sensor_layout.h"

#include "can/codec.h"

/* In a decoder: unpacks the message into `raw`, or takes a signal of it if it is in its range. */
#define UNPACK(message)                                                                                             \
    struct berth_can_##message##_t raw;                                                                             \
    if (berth_can_##message##_unpack(&raw, data, 8) < 0) {                                                          \
        return 0;                                                                                                   \
    }
#define TAKE(message, signal, place)                                                                                \
    if (!berth_can_##message##_##signal##_is_in_range(raw.signal)) {                                                \
        return 0;                                                                                                   \
    }                                                                                                               \
    wrench->place = berth_can_##message##_##signal##_decode(raw.signal)

static int decode_force(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(force)
    TAKE(force, force_n, force_N[0]);
    wrench->saturated |= raw.saturated;
    return 1;
}

static int is_at_end(double force_N, double max_N)
{
    return force_N >= max_N || force_N <= -max_N;
}

/* Of a sensor without a bit for saturation. */
static uint8_t any_at_end(const struct wrench *wrench, double max_N)
{
    int at_end = 0;
    for (int i = 0; i < SENSOR_AXES_MAX; i++) {
        at_end |= is_at_end(wrench->force_N[i], max_N);
    }
    return (uint8_t)at_end;
}

static int decode_wrench2i_force(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(wrench2i_force)
    TAKE(wrench2i_force, fx_n, force_N[0]);
    TAKE(wrench2i_force, fy_n, force_N[1]);
    TAKE(wrench2i_force, fz_n, force_N[2]);
    wrench->saturated |= any_at_end(wrench, CAN_WRENCH2I_FORCE_MAX_N);
    return 1;
}

static int decode_wrench2i_torque(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(wrench2i_torque)
    TAKE(wrench2i_torque, tx_n_m, torque_N_m[0]);
    TAKE(wrench2i_torque, ty_n_m, torque_N_m[1]);
    TAKE(wrench2i_torque, tz_n_m, torque_N_m[2]);
    return 1;
}

static int decode_wrench2m_force(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(wrench2m_force)
    TAKE(wrench2m_force, fx_n, force_N[0]);
    TAKE(wrench2m_force, fy_n, force_N[1]);
    TAKE(wrench2m_force, fz_n, force_N[2]);
    wrench->saturated |= raw.saturated;
    return 1;
}

static int decode_wrench2m_torque(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(wrench2m_torque)
    TAKE(wrench2m_torque, tx_n_m, torque_N_m[0]);
    TAKE(wrench2m_torque, ty_n_m, torque_N_m[1]);
    TAKE(wrench2m_torque, tz_n_m, torque_N_m[2]);
    wrench->saturated |= raw.saturated;
    return 1;
}

static int decode_wrench2u_force(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(wrench2u_force)
    TAKE(wrench2u_force, fx_n, force_N[0]);
    TAKE(wrench2u_force, fy_n, force_N[1]);
    TAKE(wrench2u_force, fz_n, force_N[2]);
    wrench->saturated |= any_at_end(wrench, CAN_WRENCH2U_FORCE_MAX_N);
    return 1;
}

static int decode_wrench2u_torque(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(wrench2u_torque)
    TAKE(wrench2u_torque, tx_n_m, torque_N_m[0]);
    TAKE(wrench2u_torque, ty_n_m, torque_N_m[1]);
    TAKE(wrench2u_torque, tz_n_m, torque_N_m[2]);
    return 1;
}

static int decode_wrench2s_first(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(wrench2s_first)
    if (!berth_can_wrench2s_first_response_is_in_range(raw.response)) {
        return 0;
    }
    TAKE(wrench2s_first, fx_n, force_N[0]);
    TAKE(wrench2s_first, fy_n, force_N[1]);
    TAKE(wrench2s_first, fz_n, force_N[2]);
    TAKE(wrench2s_first, tx_high_n_m, torque_N_m[0]);
    return 1;
}

static int decode_wrench2s_second(const uint8_t data[8], struct wrench *wrench)
{
    UNPACK(wrench2s_second)
    const double tx_N_m = wrench->torque_N_m[0] + berth_can_wrench2s_second_tx_low_n_m_decode(raw.tx_low_n_m);
    if (!(tx_N_m >= -CAN_WRENCH2S_TORQUE_MAX_N_m && tx_N_m <= CAN_WRENCH2S_TORQUE_MAX_N_m)) {
        return 0;
    }
    wrench->torque_N_m[0] = tx_N_m;
    TAKE(wrench2s_second, ty_n_m, torque_N_m[1]);
    TAKE(wrench2s_second, tz_n_m, torque_N_m[2]);
    wrench->saturated |= raw.overload != 0;
    return 1;
}

/* Two signals and the bit for saturation: the frames of the layouts with three. */
#define DECODE_PAIR(message, first, first_place, second, second_place)                                              \
    static int decode_##message(const uint8_t data[8], struct wrench *wrench)                                       \
    {                                                                                                               \
        UNPACK(message)                                                                                             \
        TAKE(message, first, first_place);                                                                          \
        TAKE(message, second, second_place);                                                                        \
        wrench->saturated |= raw.saturated;                                                                         \
        return 1;                                                                                                   \
    }

DECODE_PAIR(wrench3i_fx_fy, fx_n, force_N[0], fy_n, force_N[1])
DECODE_PAIR(wrench3i_fz_tx, fz_n, force_N[2], tx_n_m, torque_N_m[0])
DECODE_PAIR(wrench3i_ty_tz, ty_n_m, torque_N_m[1], tz_n_m, torque_N_m[2])
DECODE_PAIR(wrench3m_x, fx_n, force_N[0], tx_n_m, torque_N_m[0])
DECODE_PAIR(wrench3m_y, fy_n, force_N[1], ty_n_m, torque_N_m[1])
DECODE_PAIR(wrench3m_z, fz_n, force_N[2], tz_n_m, torque_N_m[2])

/* clang-format off */
const struct sensor_layout_row sensor_layouts[SENSOR_LAYOUT_COUNT] = {
    /*                      frames  axes  range, N and N m                                       step   identifier, byte and mask of the counter */
    [SENSOR_ONE_FRAME]             = {1, 1, CAN_FORCE_MAX_N,          0.0,                         1e-7, {
        {BERTH_CAN_FORCE_FRAME_ID,           7, 0xff, decode_force}}},
    [SENSOR_TWO_FRAMES_INTEL]      = {2, 3, CAN_WRENCH2I_FORCE_MAX_N, CAN_WRENCH2I_TORQUE_MAX_N_m, 1e-2, {
        {BERTH_CAN_WRENCH2I_FORCE_FRAME_ID,  6, 0xff, decode_wrench2i_force},
        {BERTH_CAN_WRENCH2I_TORQUE_FRAME_ID, 6, 0xff, decode_wrench2i_torque}}},
    [SENSOR_TWO_FRAMES_MOTOROLA]   = {2, 3, CAN_WRENCH2M_FORCE_MAX_N, CAN_WRENCH2M_TORQUE_MAX_N_m, 2e-2, {
        {BERTH_CAN_WRENCH2M_FORCE_FRAME_ID,  7, 0xff, decode_wrench2m_force},
        {BERTH_CAN_WRENCH2M_TORQUE_FRAME_ID, 7, 0xff, decode_wrench2m_torque}}},
    [SENSOR_THREE_FRAMES_INTEL]    = {3, 3, CAN_WRENCH3I_FORCE_MAX_N, CAN_WRENCH3I_TORQUE_MAX_N_m, 1e-4, {
        {BERTH_CAN_WRENCH3I_FX_FY_FRAME_ID,  7, 0xff, decode_wrench3i_fx_fy},
        {BERTH_CAN_WRENCH3I_FZ_TX_FRAME_ID,  7, 0xff, decode_wrench3i_fz_tx},
        {BERTH_CAN_WRENCH3I_TY_TZ_FRAME_ID,  7, 0xff, decode_wrench3i_ty_tz}}},
    [SENSOR_THREE_FRAMES_MOTOROLA] = {3, 3, CAN_WRENCH3M_FORCE_MAX_N, CAN_WRENCH3M_TORQUE_MAX_N_m, 1e-5, {
        {BERTH_CAN_WRENCH3M_X_FRAME_ID,      7, 0x0f, decode_wrench3m_x},
        {BERTH_CAN_WRENCH3M_Y_FRAME_ID,      7, 0x0f, decode_wrench3m_y},
        {BERTH_CAN_WRENCH3M_Z_FRAME_ID,      7, 0x0f, decode_wrench3m_z}}},
    [SENSOR_TWO_FRAMES_UNNUMBERED] = {2, 3, CAN_WRENCH2U_FORCE_MAX_N, CAN_WRENCH2U_TORQUE_MAX_N_m, 1e-2, {
        {BERTH_CAN_WRENCH2U_FORCE_FRAME_ID,  0, 0,    decode_wrench2u_force},
        {BERTH_CAN_WRENCH2U_TORQUE_FRAME_ID, 0, 0,    decode_wrench2u_torque}}},
    [SENSOR_TWO_FRAMES_UNNUMBERED_SPLIT] = {2, 3, CAN_WRENCH2S_FORCE_MAX_N, CAN_WRENCH2S_TORQUE_MAX_N_m, 2e-2, {
        {BERTH_CAN_WRENCH2S_FIRST_FRAME_ID,  0, 0,    decode_wrench2s_first},
        {BERTH_CAN_WRENCH2S_SECOND_FRAME_ID, 0, 0,    decode_wrench2s_second}}},
};
/* clang-format on */
