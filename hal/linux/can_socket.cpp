#include "can_socket.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "can_link.h"
#include "hardware_error.h"
#include "raw_frame.h"

namespace berth
{

/* What recvmmsg() fills; made once, since that costs more than a reading. */
struct can_socket::message_buffer {
    std::array<can_frame, frames_a_drain> frames;
    std::array<iovec, frames_a_drain> vectors;
    std::array<mmsghdr, frames_a_drain> messages;
    alignas(cmsghdr) std::array<std::array<char, 128>, frames_a_drain> controls;

    message_buffer()
    {
        for (std::size_t i = 0; i < frames_a_drain; i++) {
            vectors[i] = {&frames[i], sizeof frames[i]};
            messages[i] = {};
            messages[i].msg_hdr.msg_iov = &vectors[i];
            messages[i].msg_hdr.msg_iovlen = 1;
            messages[i].msg_hdr.msg_control = controls[i].data();
            make_room_for_controls(i);
        }
    }

    /* The kernel leaves there how much it has written. */
    void make_room_for_controls(std::size_t i) { messages[i].msg_hdr.msg_controllen = controls[i].size(); }
};

namespace
{

template <typename T>
void set_option(int socket, const std::string &interface, int level, int name, const T &value, const char *what)
{
    if (setsockopt(socket, level, name, &value, sizeof value) != 0) {
        fail_hardware(interface + ": " + what, errno, "this kernel's SocketCAN is too old");
    }
}

void set_filters(int socket, const std::string &interface, const std::vector<std::uint32_t> &ids,
                 const std::vector<std::uint32_t> &sent_ids)
{
    std::vector<can_filter> filters;
    for (const std::vector<std::uint32_t> *list : {&ids, &sent_ids}) {
        for (const std::uint32_t id : *list) {
            filters.push_back({id, CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_SFF_MASK});
        }
    }
    if (setsockopt(socket, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                   static_cast<socklen_t>(filters.size() * sizeof filters[0])) != 0) {
        fail_hardware(interface + ": filters cannot be set", errno, "this kernel's SocketCAN is too old");
    }
}

int open_socket(const std::string &interface)
{
    const int socket = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
    if (socket < 0 && errno == EAFNOSUPPORT) {
        fail_hardware("this kernel has no SocketCAN", errno,
                      "load the modules can and can-raw, or use a kernel that has them");
    }
    if (socket < 0) {
        fail_hardware("no CAN socket", errno, "load the modules can and can-raw");
    }
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
    if (address.can_ifindex == 0 ||
        bind(socket, reinterpret_cast<const sockaddr *>(&address), sizeof address) != 0) {
        const int error = errno;
        close(socket);
        fail_hardware(interface + ": no such CAN interface", error,
                      "`ip link` lists what there is; name them in the rig: target.robot_interface, "
                      "target.sensor_interface");
    }
    return socket;
}

} // namespace

can_socket::can_socket(hal_bus bus, const std::string &interface, const std::vector<std::uint32_t> &ids,
                       const std::vector<std::uint32_t> &sent_ids)
    : bus_(bus), interface_(interface), socket_(open_socket(interface)), buffer_(std::make_unique<message_buffer>()),
      has_hardware_stamps_(has_hardware_stamps(interface)), sent_ids_(sent_ids)
{
    try {
        set_filters(socket_, interface, ids, sent_ids);
        set_option(socket_, interface, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK},
                   "error frames cannot be had");
        set_option(socket_, interface, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, int{!sent_ids.empty()},
                   "no confirmation of sent frames");
        set_option(socket_, interface, SOL_SOCKET, SO_TIMESTAMPNS, int{1}, "no receive stamps");
        if (has_hardware_stamps_) {
            set_option(socket_, interface, SOL_SOCKET, SO_TIMESTAMPING,
                       int{SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE}, "no hardware stamps");
        }
        set_option(socket_, interface, SOL_SOCKET, SO_RXQ_OVFL, int{1}, "no count of lost frames");
    } catch (...) {
        close(socket_);
        throw;
    }
}

can_socket::~can_socket()
{
    close(socket_);
}

void can_socket::flush()
{
    can_frame frame;
    while (recv(socket_, &frame, sizeof frame, MSG_DONTWAIT) >= 0) {
    }
}

void can_socket::wait(int timeout_ms) const
{
    pollfd poll_socket{socket_, POLLIN, 0};
    poll(&poll_socket, 1, timeout_ms);
}

/* What the kernel takes of a controller that is off the bus goes nowhere, and so does what it takes from the restart
 * until its queue is open again, which is the work of a thread. Only a frame on the wire says that frames pass. */
void can_socket::lose_track()
{
    under_way_ = {};
    frames_pass_ = false;
}

void can_socket::note_error(std::uint32_t error_class, const std::uint8_t data[8])
{
    if (error_class & CAN_ERR_BUSOFF) {
        counts_.bus_off++;
        lose_track();
    }
    if (error_class & CAN_ERR_RESTARTED) {
        counts_.restarted++;
        lose_track();
    }
    if (error_class & CAN_ERR_CRTL) {
        counts_.controller_lost += (data[1] & CAN_ERR_CRTL_RX_OVERFLOW) != 0;
        counts_.error_passive += (data[1] & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0;
    }
}

/* Frames are confirmed in the order in which they were sent. What is left of those before this one has been lost. */
void can_socket::note_confirmation(const hal_frame &frame)
{
    counts_.confirmed++;
    frames_pass_ = true;
    hal_frame sent;
    while (under_way_.pop(sent)) {
        if (sent.id == frame.id && std::memcmp(sent.data, frame.data, frame.length) == 0) {
            confirmed_.push({sent.time_ns, frame.time_ns});
            return;
        }
    }
}

/* For the loop an interface that is down is a controller that has left the bus. */
void can_socket::report_down()
{
    if (is_down_) {
        return;
    }
    is_down_ = true;
    down_ns_ = read_clock_ns(CLOCK_MONOTONIC);
    lose_track();
    counts_.down++;
    hal_frame frame{};
    frame.time_ns = down_ns_;
    frame.id = CAN_ERR_BUSOFF;
    frame.bus = static_cast<std::uint8_t>(bus_);
    frame.length = CAN_ERR_DLC;
    frame.flags = HAL_FRAME_ERROR | HAL_FRAME_BUS_OFF;
    received_.push(frame);
}

/* The loop's time of a frame, from its stamps. */
std::int64_t can_socket::arrival_ns(const msghdr &header, const stamp_clock &clock)
{
    std::int64_t software_ns = 0;
    std::int64_t hardware_ns = 0;
    auto *const first = CMSG_FIRSTHDR(&header);
    for (cmsghdr *control = first; control != nullptr;
         control = CMSG_NXTHDR(const_cast<msghdr *>(&header), control)) {
        if (control->cmsg_level == SOL_SOCKET && control->cmsg_type == SCM_TIMESTAMPNS) {
            timespec stamp;
            std::memcpy(&stamp, CMSG_DATA(control), sizeof stamp);
            software_ns = clock.monotonic_ns(ns_of(stamp));
        } else if (control->cmsg_level == SOL_SOCKET && control->cmsg_type == SCM_TIMESTAMPING) {
            scm_timestamping stamps;
            std::memcpy(&stamps, CMSG_DATA(control), sizeof stamps);
            hardware_ns = ns_of({stamps.ts[2].tv_sec, stamps.ts[2].tv_nsec});
        }
    }
    /* 0: a frame of the kernel's own making, as error frames are */
    return hardware_ns == 0 ? software_ns : hardware_clock_.software_time_ns(hardware_ns, software_ns);
}

void can_socket::note_overflows(const msghdr &header)
{
    for (cmsghdr *control = CMSG_FIRSTHDR(&header); control != nullptr;
         control = CMSG_NXTHDR(const_cast<msghdr *>(&header), control)) {
        if (control->cmsg_level == SOL_SOCKET && control->cmsg_type == SO_RXQ_OVFL) {
            std::uint32_t overflows = 0;
            std::memcpy(&overflows, CMSG_DATA(control), sizeof overflows);
            counts_.socket_lost += overflows - overflows_seen_;
            overflows_seen_ = overflows;
        }
    }
}

void can_socket::take(std::size_t number, const stamp_clock &clock)
{
    const can_frame &raw = buffer_->frames[number];
    const msghdr &header = buffer_->messages[number].msg_hdr;
    hal_frame frame{};
    frame.time_ns = arrival_ns(header, clock);
    frame.id = raw.can_id & CAN_EFF_MASK;
    frame.bus = static_cast<std::uint8_t>(bus_);
    frame.length = raw.can_dlc;
    std::memcpy(frame.data, raw.data, sizeof frame.data);
    note_overflows(header);
    is_down_ = is_down_ && frame.time_ns <= down_ns_; /* what it had brought before is still there to be read */
    if (raw.can_id & CAN_ERR_FLAG) {
        note_error(raw.can_id & CAN_ERR_MASK, raw.data);
        frame.flags = HAL_FRAME_ERROR;
        frame.flags |= (raw.can_id & CAN_ERR_BUSOFF) ? HAL_FRAME_BUS_OFF : 0;
    }
    if (header.msg_flags & MSG_CONFIRM) {
        note_confirmation(frame);
        return;
    }
    counts_.received++;
    received_.push(frame);
}

void can_socket::drain(const stamp_clock &clock)
{
    const std::size_t room = std::min(frames_a_drain, queue_frames - received_.count);
    if (room == 0) {
        return; /* the loop does not keep up: the kernel's buffer counts what is lost */
    }
    const int count =
        recvmmsg(socket_, buffer_->messages.data(), static_cast<unsigned>(room), MSG_DONTWAIT, nullptr);
    if (count < 0) {
        if (errno == ENETDOWN || errno == ENODEV) {
            report_down();
        }
        return;
    }
    for (int i = 0; i < count; i++) {
        const auto number = static_cast<std::size_t>(i);
        take(number, clock);
        buffer_->make_room_for_controls(number);
    }
}

bool can_socket::receive(std::int64_t now_ns, hal_frame &frame)
{
    if (received_.count == 0 || received_.items[received_.first].time_ns > now_ns) {
        return false;
    }
    return received_.pop(frame);
}

bool can_socket::next_confirmation(can_confirmation &confirmation)
{
    return confirmed_.pop(confirmation);
}

hal_status can_socket::send(const hal_frame &frame)
{
    const can_frame raw = raw_frame(frame);
    const bool is_confirmed = (frame.flags & HAL_FRAME_REMOTE) == 0; /* the filters let no remote frame in */
    if (::send(socket_, &raw, sizeof raw, MSG_DONTWAIT) == static_cast<ssize_t>(sizeof raw)) {
        counts_.sent++;
        is_down_ = false;
        if (frames_pass_ && is_confirmed &&
            std::find(sent_ids_.begin(), sent_ids_.end(), frame.id) != sent_ids_.end()) {
            under_way_.push(frame);
        }
        return HAL_OK;
    }
    if (errno == ENETDOWN || errno == ENODEV) {
        report_down();
    }
    counts_.not_sent++;
    return HAL_NO_BUFFER;
}

void print_trouble(const can_socket &bus)
{
    const can_counts &counts = bus.counts();
    const struct {
        std::uint64_t count;
        const char *what;
    } troubles[] = {
        {counts.not_sent, "frames not sent: the transmit queue was full or the interface down"},
        {counts.socket_lost, "frames lost: the socket's buffer overflowed"},
        {counts.controller_lost, "overflows of the controller's receive buffer"},
        {counts.error_passive, "times error-passive"},
        {counts.bus_off, "times bus-off"},
        {counts.restarted, "restarts of the controller"},
        {counts.down, "times down"},
    };
    for (const auto &trouble : troubles) {
        if (trouble.count > 0) {
            std::printf("%s: %llu %s\n", bus.interface().c_str(), static_cast<unsigned long long>(trouble.count),
                        trouble.what);
        }
    }
}

} // namespace berth
