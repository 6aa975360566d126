#include "cia402_drive.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

/* Objects of CiA 402. */
constexpr od_key controlword_object = od(0x6040), statusword_object = od(0x6041), mode_wanted = od(0x6060),
                 mode_display = od(0x6061), position_actual_value = od(0x6064), target_position = od(0x607a),
                 interpolation_value = od(0x60c2, 1), interpolation_index = od(0x60c2, 2),
                 supported_modes = od(0x6502), drive_type_object = od(0x1000);

constexpr std::uint32_t servo_drive_of_cia402 = 0x00020192;
constexpr std::uint32_t cyclic_synchronous_position = 8;
constexpr std::uint32_t abort_value_range = 0x06090030;

constexpr std::uint16_t overcurrent = 0x2310;
constexpr std::uint16_t reset_bit = 0x80;

/* Bits 0 to 6 of the statusword, with voltage (bit 4) there. */
std::uint16_t state_bits(cia402_drive::power_state state)
{
    switch (state) {
    case cia402_drive::power_state::switch_on_disabled:
        return 0x50;
    case cia402_drive::power_state::ready_to_switch_on:
        return 0x31;
    case cia402_drive::power_state::switched_on:
        return 0x33;
    case cia402_drive::power_state::operation_enabled:
        return 0x37;
    case cia402_drive::power_state::fault:
        break;
    }
    return 0x18;
}

} // namespace

cia402_drive::cia402_drive(const rig &rig, robot &robot, can_bus &bus)
    : canopen_node(static_cast<std::uint8_t>(rig.firmware.cia402.node_id), bus), robot_(robot),
      counts_per_m_(rig.firmware.cia402.counts_per_m)
{
    add(drive_type_object, 4, servo_drive_of_cia402, false);
    add(controlword_object, 2, 0, true, true);
    add(statusword_object, 2, 0, false, true);
    add(mode_wanted, 1, 0, true, true);
    add(mode_display, 1, 0, false, true);
    add(position_actual_value, 4, 0, false, true);
    add(target_position, 4, 0, true, true);
    add(od(0x60c2, 0), 1, 2, false);
    add(interpolation_value, 1, 1, true);
    add(interpolation_index, 1, 0xfd, true); /* 1 ms */
    add(supported_modes, 4, 1u << (cyclic_synchronous_position - 1), false);
    enter(power_state::switch_on_disabled);
    boot(0);
}

std::uint32_t cia402_drive::check_write(od_key key, std::uint32_t value)
{
    const bool is_refused = (key == mode_wanted && value != 0 && value != cyclic_synchronous_position) ||
                            (key == interpolation_value && value == 0) ||
                            (key == interpolation_index && (value > 63 && value < 128)); /* -128 to 63 */
    return is_refused ? abort_value_range : 0;
}

void cia402_drive::written(od_key key)
{
    if (key == mode_wanted && value(mode_wanted) != 0) {
        set(mode_display, value(mode_wanted));
        enter(power_);
    } else if (key == controlword_object) {
        obey(static_cast<std::uint16_t>(value(controlword_object)));
    }
}

void cia402_drive::enter(power_state state)
{
    constexpr std::uint16_t remote = 1u << 9, follows_command = 1u << 12;
    const bool follows =
        state == power_state::operation_enabled && value(mode_display) == cyclic_synchronous_position;
    power_ = state;
    set(statusword_object, state_bits(state) | remote | (follows ? follows_command : 0u));
}

/* Commands of the controlword: bits 0 switch on, 1 enable voltage, 2 quick stop (0: stop), 3 enable operation,
 * 7 fault reset by its rising edge. Transitions are numbered as in the standard's diagram. */
void cia402_drive::obey(std::uint16_t controlword)
{
    const bool resets = (controlword & ~controlword_ & reset_bit) != 0;
    controlword_ = controlword;
    if (power_ == power_state::fault) {
        if (resets && !error_is_present_) {
            enter(power_state::switch_on_disabled); /* 15 */
            send_emergency(0, 0);
        }
        return;
    }
    const bool has_voltage = (controlword & 0x2) != 0;
    const bool quick_stop = (controlword & 0x4) == 0;
    if ((controlword & reset_bit) != 0 || !has_voltage || quick_stop) {
        return enter(power_state::switch_on_disabled); /* 7, 9, 10, 12; 11 and 12: it stops within its own cycle */
    }
    const bool switch_on = (controlword & 0x1) != 0;
    const bool enable = (controlword & 0x8) != 0;
    if (!switch_on) {
        return enter(power_state::ready_to_switch_on); /* 2, 6, 8 */
    }
    if (power_ == power_state::switch_on_disabled) {
        return; /* needs a shutdown command first */
    }
    enter(enable ? power_state::operation_enabled /* 3, 4 */ : power_state::switched_on /* 3, 5 */);
}

void cia402_drive::synchronised(std::int64_t sent_ns)
{
    if (power_ != power_state::operation_enabled || value(mode_display) != cyclic_synchronous_position) {
        return;
    }
    const auto index = static_cast<std::int8_t>(value(interpolation_index));
    const double interpolation_ns = 1e9 * static_cast<double>(value(interpolation_value)) * std::pow(10.0, index);
    const auto counts = static_cast<std::int32_t>(value(target_position));
    robot_.take_synchronous(static_cast<double>(counts) / counts_per_m_, sent_ns, std::llround(interpolation_ns));
}

void cia402_drive::set_position_m(double position_m)
{
    const double counts = std::clamp(std::round(position_m * counts_per_m_), -2147483648.0, 2147483647.0);
    set(position_actual_value, static_cast<std::uint32_t>(static_cast<std::int32_t>(counts)));
}

void cia402_drive::fail(std::uint16_t error_code, std::uint8_t error_register)
{
    enter(power_state::fault); /* 13, 14: fault reaction and fault */
    if (error_code != 0) {
        send_emergency(error_code, error_register);
    }
}

/* Abort connection option code 0x6007, as it is by default: a fault, unless there was nothing to abort. */
void cia402_drive::connection_aborted()
{
    if (power_ == power_state::operation_enabled) {
        fail(0, 0);
    }
}

void cia402_drive::set_fault(bool is_present, std::int64_t now_ns)
{
    constexpr std::uint8_t generic_and_current = 0x03;
    error_is_present_ = is_present;
    if (is_present) {
        set_now(now_ns);
        fail(overcurrent, generic_and_current);
    }
}

} // namespace berth
