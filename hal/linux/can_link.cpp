#include "can_link.h"

#include <net/if.h> /* before the kernel's own: they know of each other in this order only */

#include <linux/can/netlink.h>
#include <linux/ethtool.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/net_tstamp.h>
#include <linux/rtnetlink.h>
#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

namespace berth
{

namespace
{

template <typename T>
T value_of(const rtattr *attribute)
{
    T value{};
    std::memcpy(&value, RTA_DATA(attribute), std::min(sizeof value, std::size_t{RTA_PAYLOAD(attribute)}));
    return value;
}

/* Calls `visit` for each attribute in `bytes` bytes. */
template <typename visitor>
void for_each_attribute(const rtattr *attribute, std::size_t bytes, visitor visit)
{
    auto left = static_cast<int>(bytes);
    for (; RTA_OK(attribute, left); attribute = RTA_NEXT(attribute, left)) {
        visit(attribute);
    }
}

template <typename visitor>
void for_each_within(const rtattr *attribute, visitor visit)
{
    for_each_attribute(static_cast<const rtattr *>(RTA_DATA(attribute)), RTA_PAYLOAD(attribute), visit);
}

std::string state_name(std::uint32_t state)
{
    static const char *const names[] = {"error-active", "error-warning", "error-passive",
                                        "bus-off",      "stopped",       "sleeping"};
    return state < std::size(names) ? names[state] : "unknown";
}

void read_controller(const rtattr *attribute, can_link &link)
{
    switch (attribute->rta_type) {
    case IFLA_CAN_STATE:
        link.state = state_name(value_of<std::uint32_t>(attribute));
        break;
    case IFLA_CAN_RESTART_MS:
        link.restart_ms = value_of<std::uint32_t>(attribute);
        break;
    case IFLA_CAN_BITTIMING:
        link.bit_rate_bit_per_s = value_of<can_bittiming>(attribute).bitrate;
        break;
    default:
        break;
    }
}

void read_link_info(const rtattr *attribute, can_link &link)
{
    const std::uint16_t type = attribute->rta_type;
    if (type == IFLA_INFO_KIND) {
        link.is_virtual =
            std::strncmp(static_cast<const char *>(RTA_DATA(attribute)), "can", RTA_PAYLOAD(attribute)) != 0;
    } else if (type == IFLA_INFO_DATA) {
        for_each_within(attribute, [&](const rtattr *inner) { read_controller(inner, link); });
    }
}

void read_link(const nlmsghdr *message, can_link &link)
{
    const auto *info = static_cast<const ifinfomsg *>(NLMSG_DATA(message));
    link.is_can = info->ifi_type == ARPHRD_CAN;
    link.is_up = (info->ifi_flags & IFF_UP) != 0;
    for_each_attribute(IFLA_RTA(info), message->nlmsg_len - NLMSG_LENGTH(sizeof *info), [&](const rtattr *outer) {
        if (outer->rta_type == IFLA_TXQLEN) {
            link.transmit_queue_frames = value_of<std::uint32_t>(outer);
        } else if (outer->rta_type == IFLA_LINKINFO) {
            for_each_within(outer, [&](const rtattr *inner) { read_link_info(inner, link); });
        }
    });
}

} // namespace

bool has_hardware_stamps(const std::string &interface)
{
    ethtool_ts_info info{};
    info.cmd = ETHTOOL_GET_TS_INFO;
    ifreq request{};
    interface.copy(request.ifr_name, sizeof request.ifr_name - 1);
    request.ifr_data = reinterpret_cast<char *>(&info);
    const int socket =
        ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0); /* any will do, and the unit allows this one */
    const bool is_told = socket >= 0 && ioctl(socket, SIOCETHTOOL, &request) == 0;
    if (socket >= 0) {
        close(socket);
    }
    constexpr std::uint32_t wanted = SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE;
    return is_told && (info.so_timestamping & wanted) == wanted &&
           (info.rx_filters & (1u << HWTSTAMP_FILTER_ALL)) != 0;
}

std::optional<can_link> find_can_link(const std::string &interface)
{
    struct {
        nlmsghdr header;
        ifinfomsg info;
    } request{};
    request.header.nlmsg_len = sizeof request;
    request.header.nlmsg_type = RTM_GETLINK;
    request.header.nlmsg_flags = NLM_F_REQUEST;
    request.info.ifi_index = static_cast<int>(if_nametoindex(interface.c_str()));
    if (request.info.ifi_index == 0) {
        return {};
    }
    const int socket = ::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    alignas(nlmsghdr) std::array<char, 16384> answer{};
    ssize_t bytes = -1;
    if (socket >= 0 && send(socket, &request, sizeof request, 0) == static_cast<ssize_t>(sizeof request)) {
        bytes = recv(socket, answer.data(), answer.size(), 0);
    }
    if (socket >= 0) {
        close(socket);
    }
    const auto *message = reinterpret_cast<const nlmsghdr *>(answer.data());
    if (bytes < 0 || !NLMSG_OK(message, static_cast<std::size_t>(bytes)) || message->nlmsg_type != RTM_NEWLINK) {
        return {};
    }
    can_link link;
    read_link(message, link);
    return link;
}

} // namespace berth
