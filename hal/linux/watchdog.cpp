#include "watchdog.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "hardware_error.h"
#include "thread.h"

namespace berth
{

namespace
{
/* Well below the second that a watchdog has at least, and far above the longest period of a loop. */
constexpr std::chrono::milliseconds feed_every{250};
} // namespace

void notify_systemd(const std::string &message)
{
    const char *const path = std::getenv("NOTIFY_SOCKET");
    sockaddr_un address{};
    if (path == nullptr || path[0] == '\0' || std::strlen(path) >= sizeof address.sun_path) {
        return;
    }
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path, std::strlen(path));
    address.sun_path[0] = path[0] == '@' ? '\0' : path[0]; /* an abstract socket */
    const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    if (socket < 0) {
        return;
    }
    const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + std::strlen(path));
    sendto(socket, message.data(), message.size(), MSG_NOSIGNAL | MSG_DONTWAIT,
           reinterpret_cast<const sockaddr *>(&address), size);
    close(socket);
}

bool is_any_watchdog(const std::string &wanted)
{
    return wanted == "auto";
}

watchdog::watchdog(const std::string &wanted, const std::atomic<std::uint64_t> &ticks, const cpu_set_t &cpus,
                   const std::string &any_device)
    : ticks_(ticks), device_(is_any_watchdog(wanted) ? any_device : wanted)
{
    if (!device_.empty()) {
        file_ = open(device_.c_str(), O_WRONLY | O_CLOEXEC);
        if (file_ < 0 && is_any_watchdog(wanted)) {
            std::fprintf(stderr, "berth-target: %s: %s: goes on without this watchdog\n", device_.c_str(),
                         std::strerror(errno));
        } else if (file_ < 0) {
            fail_hardware(device_ + ": the watchdog cannot be opened", errno,
                          "is its driver loaded, and does no other program hold it? target.watchdog_device = \"\" "
                          "for none");
        }
    }
    thread_ = start_thread("watchdog", cpus, [this] { run(); });
}

watchdog::~watchdog()
{
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        is_finishing_ = true;
    }
    finish_wanted_.notify_one();
    thread_.join();
    notify_systemd("STOPPING=1");
    if (file_ >= 0) {
        if (write(file_, "V", 1) != 1) {
            std::perror(device_.c_str());
        }
        close(file_);
    }
}

void watchdog::feed()
{
    notify_systemd("WATCHDOG=1");
    if (file_ >= 0 && write(file_, "\0", 1) != 1) {
        std::perror(device_.c_str());
    }
}

void watchdog::run()
{
    std::uint64_t seen_ticks = 0;
    bool is_ready = false;
    std::unique_lock<std::mutex> lock(mutex_);
    while (!finish_wanted_.wait_for(lock, feed_every, [this] { return is_finishing_; })) {
        const std::uint64_t ticks = ticks_.load(std::memory_order_relaxed);
        if (ticks == seen_ticks) {
            continue;
        }
        seen_ticks = ticks;
        if (!is_ready) {
            notify_systemd("READY=1");
            is_ready = true;
        }
        feed();
    }
}

} // namespace berth
