/* The samples of a live view, from the bytes of a log to a socket on loopback. */
#include "../../hal/linux/live_sender.h"

#include <arpa/inet.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "../../firmware/types.h"
#include "../../hal/linux/preflight.h"
#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

constexpr std::int64_t live_period_ns = 2'500'000;

/* Takes what is sent to it. */
class live_host
{
  public:
    live_host() : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0))
    {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size_bytes = sizeof address;
        REQUIRE(bind(socket_, reinterpret_cast<sockaddr *>(&address), size_bytes) == 0);
        getsockname(socket_, reinterpret_cast<sockaddr *>(&address), &size_bytes);
        port_ = ntohs(address.sin_port);
    }
    ~live_host() { end(); }
    live_host(const live_host &) = delete;
    live_host &operator=(const live_host &) = delete;

    void end()
    {
        if (socket_ >= 0) {
            close(socket_);
        }
        socket_ = -1;
    }

    std::string address() const { return "127.0.0.1:" + std::to_string(port_); }

    std::vector<nlohmann::json> all()
    {
        std::vector<nlohmann::json> found;
        char bytes[2048];
        for (ssize_t size = 0; (size = recv(socket_, bytes, sizeof bytes, 0)) > 0;) {
            CHECK(size <= 1472);
            found.push_back(nlohmann::json::parse(bytes, bytes + size));
        }
        return found;
    }

    /* Something for the loop's machine, which nobody there reads. */
    void answer(const std::string &text) const
    {
        sockaddr_storage from{};
        socklen_t size_bytes = sizeof from;
        char bytes[2048];
        REQUIRE(recvfrom(socket_, bytes, sizeof bytes, 0, reinterpret_cast<sockaddr *>(&from), &size_bytes) > 0);
        for (int i = 0; i < 1000; i++) {
            sendto(socket_, text.data(), text.size(), 0, reinterpret_cast<sockaddr *>(&from), size_bytes);
        }
    }

  private:
    int socket_;
    int port_ = 0;
};

tick_record live_tick(std::int64_t index)
{
    tick_record record{};
    record.index = index;
    record.scheduled_ns = index * live_period_ns;
    record.woke_ns = record.scheduled_ns + 12'000;
    record.manipulator_position_m = 0.01 * static_cast<double>(index);
    record.force_N = index == 5 ? -80.0 : 1.0;
    record.limits = index == 6 ? 8 : 0;
    record.missed_ticks = index == 2 || index == 7 ? 3 : 0;
    record.state = 2;
    return record;
}

/* A message of the log. */
std::string log_message(std::uint8_t id, const void *content, std::size_t size_bytes)
{
    const auto size = static_cast<std::uint16_t>(size_bytes + 2);
    std::string bytes(reinterpret_cast<const char *>(&size), sizeof size);
    bytes += 'D';
    bytes += static_cast<char>(id);
    bytes += '\0';
    return bytes.append(static_cast<const char *>(content), size_bytes);
}

std::string live_log(std::int64_t ticks)
{
    std::string bytes;
    for (std::int64_t i = 0; i < ticks; i++) {
        const frame_record frame{};
        const tick_record record = live_tick(i);
        bytes +=
            log_message(ULOG_FRAME_ID, &frame, sizeof frame) + log_message(ULOG_TICK_ID, &record, sizeof record);
    }
    return bytes;
}

void take_parts(live_sender &sender, const std::string &bytes, std::size_t part_bytes)
{
    for (std::size_t at = 0; at < bytes.size(); at += part_bytes) {
        sender.take(reinterpret_cast<const std::uint8_t *>(bytes.data()) + at,
                    std::min(part_bytes, bytes.size() - at));
    }
}

const live_source live_test_source{"my \"rig\"\n", "00ff", live_period_ns, 42};

} // namespace

TEST_CASE("a live sender thins the log's ticks, in whatever parts the log comes")
{
    for (const std::size_t part_bytes : {1U, 3U, 7U, 300U, 100000U}) {
        CAPTURE(part_bytes);
        live_host host;
        live_sender sender(host.address(), live_test_source);
        take_parts(sender, live_log(11), part_bytes);
        const std::vector<nlohmann::json> got = host.all();
        REQUIRE(got.size() == 2); /* 400 Hz -> 100 Hz */
        CHECK(sender.sent() == 2);
        CHECK(sender.unsent() == 0);
        CHECK(got[0].at("time_s") == doctest::Approx(0.0075));
        CHECK(got[1].at("time_s") == doctest::Approx(0.0175));
        CHECK(got[1].at("manipulator_position_m") == doctest::Approx(0.07));
        CHECK(got[0].at("peak_force_N") == 1.0);
        CHECK(got[1].at("peak_force_N") == -80.0);
        CHECK(got[1].at("limits") == 8);
        CHECK(got[0].at("missed_ticks") == 3);
        CHECK(got[1].at("missed_ticks") == 6);
        CHECK(got[1].at("woke_late_ms") == doctest::Approx(0.012));
        CHECK(got[1].at("sequence") == 1);
        CHECK(got[1].at("run") == 42);
        CHECK(got[1].at("rig") == "my ?rig??");
    }
}

TEST_CASE("a live sample knows no number that JSON does not")
{
    live_host host;
    live_sender sender(host.address(), live_test_source);
    tick_record record = live_tick(0);
    record.force_N = NAN;
    record.robot_position_m = -INFINITY;
    for (int i = 0; i < 4; i++) {
        take_parts(sender, log_message(ULOG_TICK_ID, &record, sizeof record), 64);
    }
    const std::vector<nlohmann::json> got = host.all();
    REQUIRE(got.size() == 1);
    CHECK(got[0].at("force_N").is_null());
    CHECK(got[0].at("robot_position_m").is_null());
}

TEST_CASE("what the network does not take is counted, and the next sample says so")
{
    live_host host;
    live_sender sender(host.address(), live_test_source);
    const std::string log = live_log(400);
    host.end(); /* from now on the kernel answers that nobody listens */
    take_parts(sender, log, 4096);
    CHECK(sender.sent() + sender.unsent() == 100);
    CHECK(sender.unsent() > 0);
}

TEST_CASE("nothing that comes back is read")
{
    live_host host;
    live_sender sender(host.address(), live_test_source);
    take_parts(sender, live_log(4), 4096);
    host.answer(R"({"op":"run","setpoint_m":1.0})");
    take_parts(sender, live_log(4), 4096);
    CHECK(sender.sent() == 2);
    CHECK(host.all().size() == 1);
}

TEST_CASE("a live address is a numeric address and a port")
{
    for (const char *const good : {"127.0.0.1:1", "192.168.1.20:65535", "[::1]:8767", "[fe80::1]:8767"}) {
        CAPTURE(good);
        CHECK_NOTHROW(parse_live_address(good));
    }
    for (const char *const bad : {"", ":", ":8767", "127.0.0.1", "127.0.0.1:", "127.0.0.1:0", "127.0.0.1:65536",
                                  "127.0.0.1:8767x", "127.0.0.1:-1", "127.0.0.1:999999999999", "host:8767",
                                  "::1:8767", "[::1]", "[127.0.0.1]:8767", "[]:8767", "1.2.3.4.5:8767"}) {
        CAPTURE(bad);
        CHECK_THROWS_AS(parse_live_address(bad), input_error);
    }
}

TEST_CASE("the preflight says where samples go")
{
    CHECK(judge_live("127.0.0.1:8767").verdict == verdict::fine);
    const finding unreachable = judge_live("255.255.255.255:8767"); /* to everybody: not allowed */
    CHECK(unreachable.verdict == verdict::missing);
    CHECK_FALSE(unreachable.remedy.empty());
}

} // namespace berth
