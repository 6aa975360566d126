#include "live_sender.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "../log_blocks.h"
#include "../rig/rig_file.h"

namespace berth
{

namespace
{

bool fill(sockaddr_in &address, const std::string &host, std::uint16_t port)
{
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    return inet_pton(AF_INET, host.c_str(), &address.sin_addr) == 1;
}

bool fill(sockaddr_in6 &address, const std::string &host, std::uint16_t port)
{
    address.sin6_family = AF_INET6;
    address.sin6_port = htons(port);
    return inet_pton(AF_INET6, host.c_str(), &address.sin6_addr) == 1;
}

template <typename Address>
bool parse_as(const std::string &host, std::uint16_t port, live_address &into)
{
    Address address{};
    if (!fill(address, host, port)) {
        return false;
    }
    std::memcpy(&into.bytes, &address, sizeof address);
    into.size_bytes = sizeof address;
    return true;
}

/* 0: it is none. */
std::uint16_t port_of(const std::string &digits)
{
    constexpr int port_max = 65535;
    const bool is_number =
        !digits.empty() && digits.size() <= 5 && digits.find_first_not_of("0123456789") == std::string::npos;
    const int port = is_number ? std::stoi(digits) : 0;
    return static_cast<std::uint16_t>(port <= port_max ? port : 0);
}

/* It sends to one address, never blocks, and takes nothing. */
int connected_socket(const std::string &text)
{
    const live_address to = parse_live_address(text);
    const int made = socket(to.bytes.ss_family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (made < 0 || connect(made, reinterpret_cast<const sockaddr *>(&to.bytes), to.size_bytes) != 0) {
        const std::string why = std::strerror(errno);
        if (made >= 0) {
            close(made);
        }
        throw input_error("--live " + text + ": no way leads there (" + why + "); `ip route` shows the network");
    }
    shutdown(made, SHUT_RD);
    return made;
}

} // namespace

live_address parse_live_address(const std::string &text)
{
    const std::size_t colon = std::min(text.rfind(':'), text.size());
    const std::uint16_t port = port_of(text.substr(std::min(colon + 1, text.size())));
    std::string host = text.substr(0, colon);
    const bool is_bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
    if (is_bracketed) {
        host = host.substr(1, host.size() - 2);
    }
    live_address address{};
    if (port == 0 ||
        !(is_bracketed ? parse_as<sockaddr_in6>(host, port, address) : parse_as<sockaddr_in>(host, port, address))) {
        throw input_error("--live " + text +
                          ": must be a numeric address and a port, as 192.168.1.20:8767; it is that "
                          "of the computer that runs `berth live`");
    }
    return address;
}

live_sender::live_sender(const std::string &address, const live_source &source)
    : socket_(connected_socket(address)), thinner_(source)
{
}

live_sender::~live_sender()
{
    close(socket_);
}

void live_sender::take(const std::uint8_t *bytes, std::size_t size_bytes)
{
    while (size_bytes > 0) {
        std::size_t wanted_bytes = ulog_message_header_bytes;
        if (message_.size() >= ulog_message_header_bytes) {
            wanted_bytes += message_[0] + 256U * message_[1];
        }
        const std::size_t part = std::min(wanted_bytes - message_.size(), size_bytes);
        message_.insert(message_.end(), bytes, bytes + part);
        bytes += part;
        size_bytes -= part;
        if (message_.size() > ulog_message_header_bytes && message_.size() == wanted_bytes) {
            take_message();
            message_.clear();
        }
    }
}

void live_sender::take_message()
{
    tick_record record;
    if (message_.size() != ULOG_DATA_HEADER_BYTES + sizeof record || message_[2] != 'D' ||
        message_[3] != ULOG_TICK_ID || message_[4] != 0) {
        return;
    }
    std::memcpy(&record, message_.data() + ULOG_DATA_HEADER_BYTES, sizeof record);
    if (!thinner_.add(record)) {
        return;
    }
    const std::string datagram = thinner_.json(unsent_);
    const bool is_sent = send(socket_, datagram.data(), datagram.size(), MSG_DONTWAIT | MSG_NOSIGNAL) >= 0;
    (is_sent ? sent_ : unsent_)++;
}

} // namespace berth
