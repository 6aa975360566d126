/* The watchdog seen from its two ends: a file in place of the device, a socket in place of systemd. */
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <doctest/doctest.h>
#include <fstream>

#include "../../hal/linux/hardware_error.h"
#include "../../hal/linux/watchdog.h"
#include "../support/files.h"

namespace berth
{

namespace
{

class systemd_socket
{
  public:
    explicit systemd_socket(const std::string &path) : socket_(::socket(AF_UNIX, SOCK_DGRAM, 0))
    {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        REQUIRE(bind(socket_, reinterpret_cast<const sockaddr *>(&address), sizeof address) == 0);
        setenv("NOTIFY_SOCKET", path.c_str(), 1);
    }
    ~systemd_socket()
    {
        unsetenv("NOTIFY_SOCKET");
        close(socket_);
    }

    /* Empty: nothing came within `patience_ms`. */
    std::string next(int patience_ms) const
    {
        const timeval patience{patience_ms / 1000, 1000L * (patience_ms % 1000)};
        setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        char text[100];
        const ssize_t bytes = recv(socket_, text, sizeof text, 0);
        return std::string(text, bytes > 0 ? static_cast<std::size_t>(bytes) : 0);
    }

  private:
    int socket_;
};

constexpr int patience_ms = 20000;

cpu_set_t all_cpus()
{
    cpu_set_t cpus;
    sched_getaffinity(0, sizeof cpus, &cpus);
    return cpus;
}

} // namespace

TEST_CASE("watchdog: ready with the first tick, fed while ticks go on, not fed when they do not, let go at the end")
{
    const temporary_folder folder;
    const systemd_socket systemd(folder / "notify");
    const std::string device = folder / "watchdog";
    std::ofstream(device).close();
    std::atomic<std::uint64_t> ticks{0};
    {
        const watchdog guard(device, ticks, all_cpus());
        CHECK(systemd.next(700) == ""); /* no tick yet */
        ticks = 1;
        CHECK(systemd.next(patience_ms) == "READY=1");
        CHECK(systemd.next(patience_ms) == "WATCHDOG=1");
        ticks = 2;
        CHECK(systemd.next(patience_ms) == "WATCHDOG=1");
        CHECK(systemd.next(700) == ""); /* the loop hangs */
        CHECK(read_bytes(device) == std::string(2, '\0'));
    }
    CHECK(systemd.next(patience_ms) == "STOPPING=1");
    CHECK(read_bytes(device) == std::string(2, '\0') + "V");
}

TEST_CASE("watchdog: \"auto\" takes the one that is there and goes without one, a named one must be there")
{
    const temporary_folder folder;
    const systemd_socket systemd(folder / "notify");
    const std::string device = folder / "watchdog";
    std::atomic<std::uint64_t> ticks{1};
    CHECK_THROWS_AS(watchdog(device, ticks, all_cpus()), hardware_error);
    {
        const watchdog guard("auto", ticks, all_cpus(), device);
        CHECK(systemd.next(patience_ms) == "READY=1");
    }
    CHECK(!std::ifstream(device).is_open());
    std::ofstream(device).close();
    {
        const watchdog guard("auto", ticks, all_cpus(), device);
    }
    CHECK(read_bytes(device) == "V");
}

} // namespace berth
