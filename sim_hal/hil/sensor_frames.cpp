#include "sensor_frames.h"

#include <cmath>
#include <type_traits>

#include "../../firmware/can/codec.h"

namespace berth
{

namespace
{

/* To the nearest step of a signal. */
template <typename raw>
raw encoded(double value, raw (*encode)(double), double (*decode)(raw))
{
    const double step = decode(raw{1}) - decode(raw{0});
    const double offset = decode(raw{0});
    return encode(codec_round(value - offset, step) + offset);
}

#define VALUE(message, signal, value)                                                                               \
    raw.signal = encoded((value), berth_can_##message##_##signal##_encode, berth_can_##message##_##signal##_decode)

/* Starts a packer: `raw` to be filled, then PACKED. */
#define RAW(message) berth_can_##message##_t raw{};
#define COUNTER(bits) raw.counter = static_cast<decltype(raw.counter)>(counter & ((1u << (bits)) - 1u))
#define PACKED(message) return berth_can_##message##_pack(data, &raw, 8) == 8

using packer = bool (*)(std::uint8_t data[8], const wrench &sample, std::uint32_t counter);

bool pack_force(std::uint8_t data[8], const wrench &sample, std::uint32_t counter)
{
    RAW(force)
    VALUE(force, force_n, sample.force_N[0]);
    raw.saturated = sample.saturated;
    COUNTER(8);
    PACKED(force);
}

bool pack_wrench2i_force(std::uint8_t data[8], const wrench &sample, std::uint32_t counter)
{
    RAW(wrench2i_force)
    VALUE(wrench2i_force, fx_n, sample.force_N[0]);
    VALUE(wrench2i_force, fy_n, sample.force_N[1]);
    VALUE(wrench2i_force, fz_n, sample.force_N[2]);
    COUNTER(16);
    PACKED(wrench2i_force);
}

bool pack_wrench2i_torque(std::uint8_t data[8], const wrench &sample, std::uint32_t counter)
{
    RAW(wrench2i_torque)
    VALUE(wrench2i_torque, tx_n_m, sample.torque_N_m[0]);
    VALUE(wrench2i_torque, ty_n_m, sample.torque_N_m[1]);
    VALUE(wrench2i_torque, tz_n_m, sample.torque_N_m[2]);
    COUNTER(16);
    PACKED(wrench2i_torque);
}

bool pack_wrench2m_force(std::uint8_t data[8], const wrench &sample, std::uint32_t counter)
{
    RAW(wrench2m_force)
    VALUE(wrench2m_force, fx_n, sample.force_N[0]);
    VALUE(wrench2m_force, fy_n, sample.force_N[1]);
    VALUE(wrench2m_force, fz_n, sample.force_N[2]);
    raw.saturated = sample.saturated;
    COUNTER(8);
    PACKED(wrench2m_force);
}

bool pack_wrench2m_torque(std::uint8_t data[8], const wrench &sample, std::uint32_t counter)
{
    RAW(wrench2m_torque)
    VALUE(wrench2m_torque, tx_n_m, sample.torque_N_m[0]);
    VALUE(wrench2m_torque, ty_n_m, sample.torque_N_m[1]);
    VALUE(wrench2m_torque, tz_n_m, sample.torque_N_m[2]);
    raw.saturated = sample.saturated;
    COUNTER(8);
    PACKED(wrench2m_torque);
}

/* Two signals and the bit for saturation. */
#define PACK_PAIR(message, first, first_place, second, second_place, counter_bits)                                  \
    bool pack_##message(std::uint8_t data[8], const wrench &sample, std::uint32_t counter)                          \
    {                                                                                                               \
        RAW(message)                                                                                                \
        VALUE(message, first, sample.first_place);                                                                  \
        VALUE(message, second, sample.second_place);                                                                \
        raw.saturated = sample.saturated;                                                                           \
        COUNTER(counter_bits);                                                                                      \
        PACKED(message);                                                                                            \
    }

PACK_PAIR(wrench3i_fx_fy, fx_n, force_N[0], fy_n, force_N[1], 8)
PACK_PAIR(wrench3i_fz_tx, fz_n, force_N[2], tx_n_m, torque_N_m[0], 8)
PACK_PAIR(wrench3i_ty_tz, ty_n_m, torque_N_m[1], tz_n_m, torque_N_m[2], 8)
PACK_PAIR(wrench3m_x, fx_n, force_N[0], tx_n_m, torque_N_m[0], 4)
PACK_PAIR(wrench3m_y, fy_n, force_N[1], ty_n_m, torque_N_m[1], 4)
PACK_PAIR(wrench3m_z, fz_n, force_N[2], tz_n_m, torque_N_m[2], 4)

bool pack_wrench2u_force(std::uint8_t data[8], const wrench &sample, std::uint32_t)
{
    RAW(wrench2u_force)
    VALUE(wrench2u_force, fx_n, sample.force_N[0]);
    VALUE(wrench2u_force, fy_n, sample.force_N[1]);
    VALUE(wrench2u_force, fz_n, sample.force_N[2]);
    PACKED(wrench2u_force);
}

bool pack_wrench2u_torque(std::uint8_t data[8], const wrench &sample, std::uint32_t)
{
    RAW(wrench2u_torque)
    VALUE(wrench2u_torque, tx_n_m, sample.torque_N_m[0]);
    VALUE(wrench2u_torque, ty_n_m, sample.torque_N_m[1]);
    VALUE(wrench2u_torque, tz_n_m, sample.torque_N_m[2]);
    PACKED(wrench2u_torque);
}

/* Torque x of the split layout: its high byte ends the first frame, its low byte begins the second. */
std::int16_t split_torque(const wrench &sample)
{
    return static_cast<std::int16_t>(
        std::lround(sample.torque_N_m[0] / berth_can_wrench2s_second_tx_low_n_m_decode(1)));
}

bool pack_wrench2s_first(std::uint8_t data[8], const wrench &sample, std::uint32_t)
{
    RAW(wrench2s_first)
    raw.response = 11; /* force and torque */
    VALUE(wrench2s_first, fx_n, sample.force_N[0]);
    VALUE(wrench2s_first, fy_n, sample.force_N[1]);
    VALUE(wrench2s_first, fz_n, sample.force_N[2]);
    raw.tx_high_n_m = static_cast<std::int8_t>(split_torque(sample) >> 8);
    PACKED(wrench2s_first);
}

bool pack_wrench2s_second(std::uint8_t data[8], const wrench &sample, std::uint32_t)
{
    RAW(wrench2s_second)
    raw.tx_low_n_m = static_cast<std::uint8_t>(split_torque(sample) & 0xff);
    VALUE(wrench2s_second, ty_n_m, sample.torque_N_m[1]);
    VALUE(wrench2s_second, tz_n_m, sample.torque_N_m[2]);
    raw.overload = sample.saturated;
    PACKED(wrench2s_second);
}

constexpr packer packers[SENSOR_LAYOUT_COUNT][SENSOR_FRAMES_MAX] = {
    {pack_force},
    {pack_wrench2i_force, pack_wrench2i_torque},
    {pack_wrench2m_force, pack_wrench2m_torque},
    {pack_wrench3i_fx_fy, pack_wrench3i_fz_tx, pack_wrench3i_ty_tz},
    {pack_wrench3m_x, pack_wrench3m_y, pack_wrench3m_z},
    {pack_wrench2u_force, pack_wrench2u_torque},
    {pack_wrench2s_first, pack_wrench2s_second},
};

} // namespace

sensor_frames make_sensor_frames(sensor_layout layout, const wrench &sample, std::uint32_t counter)
{
    const sensor_layout_row &row = sensor_layouts[layout];
    sensor_frames made;
    for (std::size_t i = 0; i < row.frame_count; i++) {
        made.frames[i] = {0, row.frames[i].id, HAL_BUS_SENSOR, 8, 0, 0, {}};
        if (!packers[layout][i](made.frames[i].data, sample, counter)) {
            return {};
        }
    }
    made.count = row.frame_count;
    return made;
}

} // namespace berth
