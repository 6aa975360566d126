/* Sends thinned samples of the loop (live_sample.h) as UDP datagrams, from the thread that writes the log. The loop
 * does not know of it. What the network does not take is lost and counted; nothing is ever read from the socket. */
#ifndef HAL_LINUX_LIVE_SENDER_H
#define HAL_LINUX_LIVE_SENDER_H

#include <sys/socket.h>

#include <string>
#include <vector>

#include "../live_sample.h"

namespace berth
{

struct live_address {
    sockaddr_storage bytes;
    socklen_t size_bytes;
};

/* "ADDRESS:PORT", "[IPv6]:PORT": numbers only, no host names. Throws input_error. */
live_address parse_live_address(const std::string &text);

class live_sender
{
  public:
    /* Throws input_error where nothing leads to `address`, see parse_live_address(). */
    live_sender(const std::string &address, const live_source &source);
    ~live_sender();
    live_sender(const live_sender &) = delete;
    live_sender &operator=(const live_sender &) = delete;

    /* The bytes of the log as they come, in parts of any size. */
    void take(const std::uint8_t *bytes, std::size_t size_bytes);

    std::uint64_t sent() const { return sent_; }
    std::uint64_t unsent() const { return unsent_; }

  private:
    void take_message();

    int socket_;
    live_thinner thinner_;
    std::vector<std::uint8_t> message_; /* as far as it has come */
    std::uint64_t sent_ = 0;
    std::uint64_t unsent_ = 0;
};

} // namespace berth

#endif
