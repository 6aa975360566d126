#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "firmware/can/codec.h"
#include "not_finite.h"

namespace
{

/* `max` is the end of the range that the DBC gives the signal, on both sides. */
void check_range(double max, bool (*is_in_phys_range)(double))
{
    CHECK(is_in_phys_range(max));
    CHECK(is_in_phys_range(-max));
    CHECK_FALSE(is_in_phys_range(std::nextafter(max, infinity)));
    CHECK_FALSE(is_in_phys_range(std::nextafter(-max, -infinity)));
}

} // namespace

TEST_CASE("codec: the ranges in codec.h are those of the DBC")
{
    check_range(CAN_POSITION_MAX_m, berth_can_setpoint_position_m_is_in_phys_range);
    check_range(CAN_POSITION_MAX_m, berth_can_robot_feedback_position_m_is_in_phys_range);
    check_range(CAN_FORCE_MAX_N, berth_can_force_force_n_is_in_phys_range);
    check_range(CAN_FORCE_MAX_N, berth_can_operator_force_force_n_is_in_phys_range);
    check_range(CAN_WRENCH2I_FORCE_MAX_N, berth_can_wrench2i_force_fz_n_is_in_phys_range);
    check_range(CAN_WRENCH2M_FORCE_MAX_N, berth_can_wrench2m_force_fz_n_is_in_phys_range);
    check_range(CAN_WRENCH3I_FORCE_MAX_N, berth_can_wrench3i_fz_tx_fz_n_is_in_phys_range);
    check_range(CAN_WRENCH3M_FORCE_MAX_N, berth_can_wrench3m_z_fz_n_is_in_phys_range);
    check_range(CAN_WRENCH2I_TORQUE_MAX_N_m, berth_can_wrench2i_torque_tx_n_m_is_in_phys_range);
    check_range(CAN_WRENCH2M_TORQUE_MAX_N_m, berth_can_wrench2m_torque_ty_n_m_is_in_phys_range);
    check_range(CAN_WRENCH3I_TORQUE_MAX_N_m, berth_can_wrench3i_ty_tz_tz_n_m_is_in_phys_range);
    check_range(CAN_WRENCH3M_TORQUE_MAX_N_m, berth_can_wrench3m_z_tz_n_m_is_in_phys_range);
    check_range(CAN_WRENCH2U_FORCE_MAX_N, berth_can_wrench2u_force_fz_n_is_in_phys_range);
    check_range(CAN_WRENCH2U_TORQUE_MAX_N_m, berth_can_wrench2u_torque_tz_n_m_is_in_phys_range);
    check_range(CAN_WRENCH2S_FORCE_MAX_N, berth_can_wrench2s_first_fz_n_is_in_phys_range);
    check_range(CAN_WRENCH2S_TORQUE_MAX_N_m, berth_can_wrench2s_second_tz_n_m_is_in_phys_range);
    check_range(CAN_OPERATOR_POSITION_MAX_m, berth_can_operator_motion_position_m_is_in_phys_range);
    check_range(CAN_OPERATOR_VELOCITY_MAX_m_per_s, berth_can_operator_motion_velocity_m_per_s_is_in_phys_range);
}

TEST_CASE("codec: the ends of the ranges fit into their bits, with room for rounding")
{
    CHECK(CAN_POSITION_MAX_m / berth_can_setpoint_position_m_decode(1) + 1.0 < std::ldexp(1.0, 39));
    CHECK(CAN_FORCE_MAX_N / berth_can_force_force_n_decode(1) + 1.0 < std::ldexp(1.0, 39));
    CHECK(CAN_OPERATOR_POSITION_MAX_m / berth_can_operator_motion_position_m_decode(1) + 1.0 < std::ldexp(1.0, 31));
    CHECK(CAN_OPERATOR_VELOCITY_MAX_m_per_s / berth_can_operator_motion_velocity_m_per_s_decode(1) + 1.0 <
          std::ldexp(1.0, 23));
}

TEST_CASE("codec: the steps are fine enough never to shape a result")
{
    CHECK(berth_can_setpoint_position_m_decode(1) <= 1e-7);
    CHECK(berth_can_force_force_n_decode(1) <= 0.01);
}

TEST_CASE("codec: saturation keeps the sign, counts, and never lets a NaN through")
{
    const struct {
        double value, expected;
        bool saturated;
    } rows[] = {
        {0.0, 0.0, false},   {5.4, 5.4, false},         {-5.4, -5.4, false},     {5.5, 5.4, true},
        {-5.5, -5.4, true},  {infinity, 5.4, true},     {-infinity, -5.4, true}, {1e300, 5.4, true},
        {1e-9, 1e-9, false}, {std::nan(""), 0.0, true},
    };
    for (const auto &row : rows) {
        CAPTURE(row.value);
        bool saturated = false;
        CHECK(codec_saturate(row.value, 5.4, &saturated) == row.expected);
        CHECK(saturated == row.saturated);
    }
    bool earlier = true;
    codec_saturate(0.0, 5.4, &earlier);
    CHECK(earlier); /* several signals of a frame share one flag */
}

TEST_CASE("codec: truncation after codec_round is rounding to nearest")
{
    for (const double steps : {0.0, 0.4, 0.6, 1.4, 1.6, 41.9}) {
        CAPTURE(steps);
        const auto nearest = static_cast<std::int64_t>(std::llround(steps));
        CHECK(berth_can_force_force_n_encode(codec_round(steps * 1e-7, 1e-7)) == nearest);
        CHECK(berth_can_force_force_n_encode(codec_round(-steps * 1e-7, 1e-7)) == -nearest);
    }
}
