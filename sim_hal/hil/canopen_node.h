/* A CANopen device as CiA 301 describes it: object dictionary with an expedited SDO server, NMT slave, heartbeat
 * producer and consumer, emergency messages, one receive and one transmit PDO with free mapping. What the device is
 * for stands in a class derived from it. */
#ifndef SIM_HAL_HIL_CANOPEN_NODE_H
#define SIM_HAL_HIL_CANOPEN_NODE_H

#include <cstdint>
#include <limits>
#include <map>
#include <vector>

#include "../../hal/hal.h"
#include "can_bus.h"

namespace berth
{

/* Index and subindex of an object: 0xIIIISS. */
using od_key = std::uint32_t;

constexpr od_key od(std::uint32_t index, std::uint32_t subindex = 0)
{
    return index << 8 | subindex;
}

struct od_entry {
    std::uint32_t value;
    std::uint8_t bytes;
    bool is_writable;
    bool is_mappable;
};

enum class nmt_state : std::uint8_t { boot_up = 0, stopped = 4, operational = 5, pre_operational = 127 };

class canopen_node
{
  public:
    canopen_node(std::uint8_t node_id, can_bus &bus);
    virtual ~canopen_node() = default;
    canopen_node(const canopen_node &) = delete;
    canopen_node &operator=(const canopen_node &) = delete;

    /* A frame on the bus, sent at frame.time_ns, with its end at `arrival_ns`. */
    void receive(const hal_frame &frame, std::int64_t arrival_ns);

    /* When the node next does something by itself, and doing it. */
    std::int64_t next_event_ns() const;
    void handle_event();

    /* When the process data that the newest SYNC asks for are to be sampled, `never_ns` if none: as setpoints act,
     * at the instant at which it was sent, since dead times include its time on the bus. */
    std::int64_t next_sample_ns() const { return sample_ns_; }
    /* Sends them, as the dictionary has them now; or does not. */
    void send_samples();
    void drop_samples() { sample_ns_ = never_ns; }

    /* The frame carries process data to the node. */
    bool is_process_data(const hal_frame &frame) const { return frame.id == (value(od(0x1400, 1)) & 0x7ffu); }

    /* Sends nothing while silent. */
    void set_silent(bool silent) { is_silent_ = silent; }

    nmt_state state() const { return state_; }
    std::uint32_t value(od_key key) const { return objects_.at(key).value; }

    static constexpr std::int64_t never_ns = std::numeric_limits<std::int64_t>::max();

  protected:
    void add(od_key key, std::uint8_t bytes, std::uint32_t value, bool is_writable, bool is_mappable = false);
    void set(od_key key, std::uint32_t value) { objects_.at(key).value = value; }

    /* An object is about to be written, by SDO or PDO: the abort code that refuses it, or 0. */
    virtual std::uint32_t check_write(od_key, std::uint32_t) { return 0; }
    /* It has been written. */
    virtual void written(od_key) {}
    /* SYNC, sent at `sent_ns`; what waited for it has been written. */
    virtual void synchronised(std::int64_t /*sent_ns*/) {}
    /* The master is gone, or has left the node alone: heartbeat, NMT stop or reset. */
    virtual void connection_aborted() {}

    /* Emergency message; 0: all errors are gone. */
    void send_emergency(std::uint16_t error_code, std::uint8_t error_register);
    void boot(std::int64_t now_ns);
    void set_now(std::int64_t now_ns) { now_ns_ = now_ns; } /* something happens by itself */

  private:
    struct received_pdo {
        bool waits_for_sync = false;
        std::uint8_t length = 0;
        std::uint8_t data[8] = {};
    };

    void set_communication_defaults();
    void receive_nmt(const hal_frame &frame);
    void receive_sdo(const hal_frame &frame);
    void receive_pdo(const hal_frame &frame);
    void receive_sync(const hal_frame &frame);
    void receive_heartbeat(std::uint32_t node);
    std::uint32_t download(od_key key, std::uint32_t value, std::uint32_t bytes);
    std::uint32_t check_pdo_write(od_key key, std::uint32_t value) const;
    std::vector<od_key> mapping(std::uint32_t index) const;
    void write_pdo(const std::uint8_t *data, std::uint8_t length);
    void change_state(nmt_state state);
    void send(std::uint32_t id, const std::uint8_t *data, std::uint8_t length);

    can_bus &bus_;
    std::uint8_t node_id_;
    std::map<od_key, od_entry> objects_;
    nmt_state state_ = nmt_state::boot_up;
    received_pdo received_;
    std::int64_t now_ns_ = 0; /* end of the frame, or the event, that is being handled */
    std::int64_t sample_ns_ = never_ns;
    std::int64_t samples_ready_ns_ = 0;
    std::int64_t heartbeat_ns_ = never_ns;
    std::int64_t consumer_ns_ = never_ns; /* the master's heartbeat is missed from then on */
    std::uint32_t syncs_ = 0;             /* since the last transmission */
    bool is_silent_ = false;
};

} // namespace berth

#endif
