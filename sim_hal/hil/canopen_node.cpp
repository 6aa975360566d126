#include "canopen_node.h"

#include <algorithm>
#include <cstring>

namespace berth
{

namespace
{

constexpr std::uint32_t nmt_id = 0x000, sync_id = 0x080, emergency_id = 0x080, sdo_request_id = 0x600,
                        sdo_answer_id = 0x580, heartbeat_id = 0x700;
constexpr std::uint32_t id_mask = 0x7ff;

/* Communication objects of CiA 301. */
constexpr od_key device_type = od(0x1000), error_register = od(0x1001), cycle_period_us = od(0x1006),
                 consumer_heartbeat = od(0x1016, 1), producer_heartbeat_ms = od(0x1017), vendor = od(0x1018, 1);
constexpr std::uint32_t rpdo = 0x1400, rpdo_mapping = 0x1600, tpdo = 0x1800, tpdo_mapping = 0x1a00;
constexpr std::uint32_t mapped_max = 8;
constexpr std::uint32_t pdo_is_invalid = 0x80000000u;
constexpr std::uint32_t last_synchronous_type = 240;

/* Abort codes of CiA 301. */
constexpr std::uint32_t abort_command = 0x05040001, abort_read_only = 0x06010002, abort_no_object = 0x06020000,
                        abort_not_mappable = 0x06040041, abort_pdo_length = 0x06040042,
                        abort_wrong_length = 0x06070010, abort_no_subindex = 0x06090011, abort_range = 0x06090030,
                        abort_device_state = 0x08000022;

std::uint32_t number(const std::uint8_t *bytes, std::uint32_t count)
{
    std::uint32_t value = 0;
    for (std::uint32_t i = count; i-- > 0;) {
        value = value << 8 | bytes[i];
    }
    return value;
}

void put(std::uint8_t *bytes, std::uint32_t count, std::uint32_t value)
{
    for (std::uint32_t i = 0; i < count; i++, value >>= 8) {
        bytes[i] = static_cast<std::uint8_t>(value);
    }
}

} // namespace

canopen_node::canopen_node(std::uint8_t node_id, can_bus &bus) : bus_(bus), node_id_(node_id)
{
    add(device_type, 4, 0, false);
    add(error_register, 1, 0, false);
    add(cycle_period_us, 4, 0, true);
    add(od(0x1016, 0), 1, 1, false);
    add(consumer_heartbeat, 4, 0, true);
    add(producer_heartbeat_ms, 2, 0, true);
    add(od(0x1018, 0), 1, 1, false);
    add(vendor, 4, 0, false);
    for (const std::uint32_t index : {rpdo, tpdo}) {
        add(od(index, 0), 1, 2, false);
        add(od(index, 1), 4, 0, true);
        add(od(index, 2), 1, 0, true);
    }
    for (const std::uint32_t index : {rpdo_mapping, tpdo_mapping}) {
        add(od(index, 0), 1, 0, true);
        for (std::uint32_t i = 1; i <= mapped_max; i++) {
            add(od(index, i), 4, 0, true);
        }
    }
    set_communication_defaults();
}

void canopen_node::add(od_key key, std::uint8_t bytes, std::uint32_t value, bool is_writable, bool is_mappable)
{
    objects_[key] = {value, bytes, is_writable, is_mappable};
}

/* Predefined connection set; PDOs event-driven as profiles have them, and not mapped. */
void canopen_node::set_communication_defaults()
{
    constexpr std::uint32_t event_driven = 255;
    set(cycle_period_us, 0);
    set(consumer_heartbeat, 0);
    set(producer_heartbeat_ms, 0);
    set(od(rpdo, 1), 0x200u + node_id_);
    set(od(tpdo, 1), 0x180u + node_id_);
    for (const std::uint32_t index : {rpdo, tpdo}) {
        set(od(index, 2), event_driven);
    }
    set(od(rpdo_mapping, 0), 0);
    set(od(tpdo_mapping, 0), 0);
}

void canopen_node::boot(std::int64_t now_ns)
{
    now_ns_ = now_ns;
    set_communication_defaults();
    heartbeat_ns_ = never_ns;
    consumer_ns_ = never_ns;
    sample_ns_ = never_ns;
    received_ = {};
    set(error_register, 0);
    const auto boot_up = static_cast<std::uint8_t>(nmt_state::boot_up);
    send(heartbeat_id + node_id_, &boot_up, 1);
    state_ = nmt_state::pre_operational;
}

void canopen_node::send(std::uint32_t id, const std::uint8_t *data, std::uint8_t length)
{
    if (is_silent_) {
        return;
    }
    hal_frame frame{0, id, HAL_BUS_ROBOT, length, 0, 0, {}};
    std::memcpy(frame.data, data, length);
    bus_.transmit_to_loop(frame, now_ns_);
}

void canopen_node::receive(const hal_frame &frame, std::int64_t arrival_ns)
{
    now_ns_ = arrival_ns;
    if (frame.id == nmt_id) {
        receive_nmt(frame);
    } else if (frame.id == sync_id) {
        receive_sync(frame);
    } else if (frame.id == sdo_request_id + node_id_) {
        receive_sdo(frame);
    } else if (frame.id == (value(od(rpdo, 1)) & id_mask)) {
        receive_pdo(frame);
    } else if (frame.id > heartbeat_id) {
        receive_heartbeat(frame.id - heartbeat_id);
    }
}

void canopen_node::change_state(nmt_state state)
{
    if (state != nmt_state::operational) {
        sample_ns_ = never_ns;
        received_ = {};
    }
    state_ = state;
}

void canopen_node::receive_nmt(const hal_frame &frame)
{
    if (frame.length != 2 || (frame.data[1] != 0 && frame.data[1] != node_id_)) {
        return;
    }
    switch (frame.data[0]) {
    case 0x01:
        return change_state(nmt_state::operational);
    case 0x02:
        connection_aborted();
        return change_state(nmt_state::stopped);
    case 0x80:
        return change_state(nmt_state::pre_operational);
    case 0x81: /* reset node */
    case 0x82: /* reset communication */
        connection_aborted();
        return boot(now_ns_);
    default:
        return;
    }
}

/* SDO server, expedited transfers only. */
void canopen_node::receive_sdo(const hal_frame &frame)
{
    if (frame.length != 8 || state_ == nmt_state::stopped) {
        return;
    }
    const std::uint8_t command = frame.data[0];
    const std::uint32_t index = number(frame.data + 1, 2);
    const od_key key = od(index, frame.data[3]);
    constexpr std::uint8_t abort = 0x80, upload = 0x40, download_expedited = 0x22;
    if (command == abort) {
        return;
    }
    std::uint8_t answer[8] = {0, frame.data[1], frame.data[2], frame.data[3], 0, 0, 0, 0};
    std::uint32_t code = 0;
    const auto found = objects_.find(key);
    if (found == objects_.end()) {
        code = objects_.find(od(index, 0)) == objects_.end() ? abort_no_object : abort_no_subindex;
    } else if ((command & 0xe0) == upload) {
        answer[0] = static_cast<std::uint8_t>(0x43 | (4 - found->second.bytes) << 2);
        put(answer + 4, found->second.bytes, found->second.value);
    } else if ((command & 0xe2) == download_expedited) {
        const bool tells_size = (command & 1) != 0;
        const std::uint32_t bytes = tells_size ? 4u - (command >> 2 & 3u) : found->second.bytes;
        code = download(key, number(frame.data + 4, bytes), bytes);
        answer[0] = 0x60;
    } else {
        code = abort_command;
    }
    if (code != 0) {
        answer[0] = abort;
        put(answer + 4, 4, code);
    }
    send(sdo_answer_id + node_id_, answer, 8);
    if (code == 0 && (command & 0xe2) == download_expedited) {
        written(key);
    }
}

std::uint32_t canopen_node::download(od_key key, std::uint32_t value, std::uint32_t bytes)
{
    od_entry &entry = objects_.at(key);
    if (!entry.is_writable) {
        return abort_read_only;
    }
    if (bytes != entry.bytes) {
        return abort_wrong_length;
    }
    std::uint32_t code = check_pdo_write(key, value);
    code = code != 0 ? code : check_write(key, value);
    if (code != 0) {
        return code;
    }
    entry.value = value;
    if (key == producer_heartbeat_ms) {
        heartbeat_ns_ = value > 0 ? now_ns_ : never_ns;
    } else if (key == consumer_heartbeat) {
        consumer_ns_ = never_ns; /* begins with the first heartbeat */
    }
    return 0;
}

/* A PDO is changed while it is disabled, and its mapping while it maps nothing. */
std::uint32_t canopen_node::check_pdo_write(od_key key, std::uint32_t value) const
{
    const std::uint32_t index = key >> 8;
    const std::uint32_t subindex = key & 0xff;
    if ((index == rpdo || index == tpdo) && subindex == 1) {
        const bool is_valid = (this->value(key) & pdo_is_invalid) == 0;
        const bool changes_id = ((this->value(key) ^ value) & id_mask) != 0;
        return is_valid && (value & pdo_is_invalid) == 0 && changes_id ? abort_range : 0;
    }
    if (index != rpdo_mapping && index != tpdo_mapping) {
        return 0;
    }
    const od_key parameter = od(index == rpdo_mapping ? rpdo : tpdo, 1);
    if ((this->value(parameter) & pdo_is_invalid) == 0 || (subindex > 0 && this->value(od(index, 0)) != 0)) {
        return abort_device_state;
    }
    if (subindex == 0) {
        std::uint32_t bits = 0;
        for (std::uint32_t i = 1; i <= value && i <= mapped_max; i++) {
            bits += this->value(od(index, i)) & 0xff;
        }
        return value > mapped_max || bits > 64 ? abort_pdo_length : 0;
    }
    const auto mapped = objects_.find(value >> 8);
    const bool fits = mapped != objects_.end() && mapped->second.is_mappable &&
                      (value & 0xff) == 8u * mapped->second.bytes &&
                      (index == tpdo_mapping || mapped->second.is_writable);
    return fits ? 0 : abort_not_mappable;
}

std::vector<od_key> canopen_node::mapping(std::uint32_t index) const
{
    std::vector<od_key> keys;
    for (std::uint32_t i = 1; i <= value(od(index, 0)); i++) {
        keys.push_back(value(od(index, i)) >> 8);
    }
    return keys;
}

void canopen_node::receive_pdo(const hal_frame &frame)
{
    if (state_ != nmt_state::operational || (value(od(rpdo, 1)) & pdo_is_invalid) != 0) {
        return;
    }
    if (value(od(rpdo, 2)) <= last_synchronous_type) {
        received_.waits_for_sync = true;
        received_.length = frame.length;
        std::memcpy(received_.data, frame.data, sizeof received_.data);
        return;
    }
    write_pdo(frame.data, frame.length);
}

void canopen_node::write_pdo(const std::uint8_t *data, std::uint8_t length)
{
    std::uint32_t at = 0;
    for (const od_key key : mapping(rpdo_mapping)) {
        const std::uint32_t bytes = objects_.at(key).bytes;
        if (at + bytes > length) {
            return; /* too short for its mapping */
        }
        const std::uint32_t value = number(data + at, bytes);
        at += bytes;
        if (check_write(key, value) == 0) {
            set(key, value);
            written(key);
        }
    }
}

void canopen_node::receive_sync(const hal_frame &frame)
{
    if (state_ != nmt_state::operational) {
        return;
    }
    if (received_.waits_for_sync) {
        received_.waits_for_sync = false;
        write_pdo(received_.data, received_.length);
    }
    synchronised(frame.time_ns);
    const std::uint32_t type = value(od(tpdo, 2));
    if (type >= 1 && type <= last_synchronous_type && (value(od(tpdo, 1)) & pdo_is_invalid) == 0 &&
        ++syncs_ >= type) {
        syncs_ = 0;
        sample_ns_ = frame.time_ns;
        samples_ready_ns_ = now_ns_;
    }
}

void canopen_node::send_samples()
{
    now_ns_ = samples_ready_ns_;
    sample_ns_ = never_ns;
    std::uint8_t data[8] = {};
    std::uint32_t at = 0;
    for (const od_key key : mapping(tpdo_mapping)) {
        put(data + at, objects_.at(key).bytes, value(key));
        at += objects_.at(key).bytes;
    }
    send(value(od(tpdo, 1)) & id_mask, data, static_cast<std::uint8_t>(at));
}

void canopen_node::receive_heartbeat(std::uint32_t node)
{
    const std::uint32_t watched = value(consumer_heartbeat);
    if (node == (watched >> 16 & 0x7f) && (watched & 0xffff) != 0) {
        consumer_ns_ = now_ns_ + 1000000 * static_cast<std::int64_t>(watched & 0xffff);
    }
}

std::int64_t canopen_node::next_event_ns() const
{
    return std::min(heartbeat_ns_, consumer_ns_);
}

void canopen_node::handle_event()
{
    now_ns_ = next_event_ns();
    if (now_ns_ == consumer_ns_) { /* error behaviour 0x1029, as it is by default: back to pre-operational */
        constexpr std::uint16_t heartbeat_error = 0x8130;
        constexpr std::uint8_t generic_and_communication = 0x11;
        consumer_ns_ = never_ns;
        send_emergency(heartbeat_error, generic_and_communication);
        connection_aborted();
        if (state_ == nmt_state::operational) {
            change_state(nmt_state::pre_operational);
        }
        return;
    }
    const auto told = static_cast<std::uint8_t>(state_);
    send(heartbeat_id + node_id_, &told, 1);
    heartbeat_ns_ += 1000000 * static_cast<std::int64_t>(value(producer_heartbeat_ms));
}

void canopen_node::send_emergency(std::uint16_t error_code, std::uint8_t error_register_bits)
{
    set(error_register, error_register_bits);
    std::uint8_t data[8] = {};
    put(data, 2, error_code);
    data[2] = error_register_bits;
    send(emergency_id + node_id_, data, 8);
}

} // namespace berth
