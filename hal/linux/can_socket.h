/* One CAN bus through SocketCAN: exact identifiers only, error frames, receive stamps: the controller's own where
 * its driver offers them, else the kernel's. Nothing here waits: frames are drained once a tick and a frame that
 * finds no room is dropped. */
#ifndef HAL_LINUX_CAN_SOCKET_H
#define HAL_LINUX_CAN_SOCKET_H

#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "../hal.h"
#include "hardware_clock.h"
#include "loop_time.h"

namespace berth
{

struct can_counts {
    std::uint64_t received = 0;
    std::uint64_t sent = 0;
    std::uint64_t confirmed = 0;       /* sent frames that the driver reports to be on the wire */
    std::uint64_t not_sent = 0;        /* transmit queue full or interface down: dropped, never retried */
    std::uint64_t socket_lost = 0;     /* the socket's own buffer overflowed (SO_RXQ_OVFL) */
    std::uint64_t controller_lost = 0; /* the controller's receive buffer overflowed */
    std::uint64_t error_passive = 0;
    std::uint64_t bus_off = 0;
    std::uint64_t restarted = 0;
    std::uint64_t down = 0; /* the interface went down */
};

/* A frame of our own that the driver reports to be on the wire. */
struct can_confirmation {
    std::int64_t handed_over_ns; /* time_ns of the frame as it was sent */
    std::int64_t on_wire_ns;     /* CLOCK_MONOTONIC */
};

class can_socket
{
  public:
    /* Listens to `ids`, and to its own frames among `sent_ids` to see them confirmed. Throws hardware_error. */
    can_socket(hal_bus bus, const std::string &interface, const std::vector<std::uint32_t> &ids,
               const std::vector<std::uint32_t> &sent_ids = {});
    ~can_socket();
    can_socket(const can_socket &) = delete;
    can_socket &operator=(const can_socket &) = delete;

    /* Forgets what has arrived so far. */
    void flush();

    /* Takes what has arrived, up to a bound; the rest stays in the kernel for the next tick. */
    void drain(const stamp_clock &clock);

    /* The oldest drained frame that arrived by `now_ns` (CLOCK_MONOTONIC, as is frame.time_ns). */
    bool receive(std::int64_t now_ns, hal_frame &frame);

    /* Oldest first. */
    bool next_confirmation(can_confirmation &confirmation);

    hal_status send(const hal_frame &frame);

    /* Waits for frames at most so long. For programs without a tick. */
    void wait(int timeout_ms) const;

    const can_counts &counts() const { return counts_; }
    const std::string &interface() const { return interface_; }

    /* Who stamps received frames: "hardware" or "software". */
    const char *stamps() const { return has_hardware_stamps_ ? "hardware" : "software"; }

  private:
    static constexpr std::size_t frames_a_drain = 64;
    static constexpr std::size_t queue_frames = 4 * frames_a_drain;

    template <typename item>
    struct queue {
        std::array<item, queue_frames> items;
        std::size_t first = 0;
        std::size_t count = 0;

        bool push(const item &one)
        {
            if (count == items.size()) {
                return false;
            }
            items[(first + count++) % items.size()] = one;
            return true;
        }
        bool pop(item &one)
        {
            if (count == 0) {
                return false;
            }
            one = items[first];
            first = (first + 1) % items.size();
            count--;
            return true;
        }
    };
    struct message_buffer;

    void take(std::size_t number, const stamp_clock &clock);
    std::int64_t arrival_ns(const msghdr &header, const stamp_clock &clock);
    void note_overflows(const msghdr &header);
    void note_confirmation(const hal_frame &frame);
    void note_error(std::uint32_t error_class, const std::uint8_t data[8]);
    void lose_track();
    void report_down();

    hal_bus bus_;
    std::string interface_;
    int socket_ = -1;
    std::unique_ptr<message_buffer> buffer_;
    bool has_hardware_stamps_ = false;
    hardware_clock hardware_clock_;
    bool is_down_ = false;
    bool frames_pass_ = true;  /* what the kernel takes comes to the wire, as far as is known */
    std::int64_t down_ns_ = 0; /* since when */
    std::uint32_t overflows_seen_ = 0;
    can_counts counts_;
    queue<hal_frame> received_;
    std::vector<std::uint32_t> sent_ids_; /* of frames that are to be seen confirmed */
    queue<hal_frame> under_way_;          /* of those, the ones that are not yet */
    queue<can_confirmation> confirmed_;
};

/* What went wrong on the bus, on stdout; nothing if all is well. */
void print_trouble(const can_socket &bus);

} // namespace berth

#endif
