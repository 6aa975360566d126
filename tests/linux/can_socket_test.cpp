/* can_socket against the kernel's own virtual CAN: two sockets on vcan0, where everyone hears everyone. */
#include <linux/can.h>
#include <linux/can/error.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstring>
#include <doctest/doctest.h>

#include "../../hal/linux/can_socket.h"

namespace berth
{

namespace
{

constexpr std::uint32_t id = 0x40;
constexpr std::int64_t end_of_time_ns = INT64_MAX;

hal_frame frame_of(std::uint32_t frame_id, std::uint8_t first_byte = 0, std::uint8_t second_byte = 0)
{
    return {0, frame_id, HAL_BUS_SENSOR, 8, 0, 0, {first_byte, second_byte}};
}

bool set_up(const char *interface, bool is_up)
{
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
    ifreq request{};
    std::strncpy(request.ifr_name, interface, sizeof request.ifr_name - 1);
    bool is_done = ioctl(socket, SIOCGIFFLAGS, &request) == 0;
    request.ifr_flags = static_cast<short>(is_up ? request.ifr_flags | IFF_UP : request.ifr_flags & ~IFF_UP);
    is_done = is_done && ioctl(socket, SIOCSIFFLAGS, &request) == 0;
    close(socket);
    return is_done;
}

std::vector<hal_frame> drain(can_socket &socket)
{
    stamp_clock clock;
    clock.update();
    socket.drain(clock);
    std::vector<hal_frame> frames;
    hal_frame frame;
    while (socket.receive(end_of_time_ns, frame)) {
        frames.push_back(frame);
    }
    return frames;
}

} // namespace

TEST_CASE("bus: a socket hears its identifiers and no others")
{
    can_socket listener(HAL_BUS_SENSOR, "vcan0", {id});
    can_socket talker(HAL_BUS_SENSOR, "vcan0", {});
    for (const std::uint32_t other : {id + 1, id, 0x7ffu, id | CAN_EFF_FLAG, id | CAN_RTR_FLAG}) {
        REQUIRE(talker.send(frame_of(other, 7)) == HAL_OK);
    }
    const std::vector<hal_frame> frames = drain(listener);
    REQUIRE(frames.size() == 1);
    CHECK(frames[0].id == id);
    CHECK(frames[0].bus == HAL_BUS_SENSOR);
    CHECK(frames[0].length == 8);
    CHECK(frames[0].flags == 0);
    CHECK(frames[0].data[0] == 7);
    CHECK(drain(talker).empty());
}

TEST_CASE("bus: a frame is stamped between its sending and its reading, and waits until its time has come")
{
    can_socket listener(HAL_BUS_SENSOR, "vcan0", {id});
    can_socket talker(HAL_BUS_SENSOR, "vcan0", {});
    const std::int64_t before_ns = read_clock_ns(CLOCK_MONOTONIC);
    REQUIRE(talker.send(frame_of(id)) == HAL_OK);
    stamp_clock clock;
    clock.update();
    listener.drain(clock);
    const std::int64_t after_ns = read_clock_ns(CLOCK_MONOTONIC);
    hal_frame frame;
    CHECK(!listener.receive(before_ns - 1000000, frame));
    REQUIRE(listener.receive(after_ns, frame));
    CHECK(frame.time_ns >= before_ns - 1000); /* the two clocks are read one after the other */
    CHECK(frame.time_ns <= after_ns);
}

TEST_CASE("bus: own frames come back as confirmed, those of others with the same identifier as received")
{
    can_socket loop(HAL_BUS_ROBOT, "vcan0", {0x20}, {0x10});
    can_socket other(HAL_BUS_ROBOT, "vcan0", {});
    hal_frame own = frame_of(0x10, 1);
    own.time_ns = 4711;
    const std::int64_t before_ns = read_clock_ns(CLOCK_MONOTONIC);
    REQUIRE(loop.send(own) == HAL_OK);
    REQUIRE(loop.send(frame_of(0x11)) == HAL_OK); /* nobody asks when */
    REQUIRE(other.send(frame_of(0x10, 2)) == HAL_OK);
    const std::vector<hal_frame> frames = drain(loop);
    REQUIRE(frames.size() == 1);
    CHECK(frames[0].data[0] == 2);
    can_confirmation confirmed;
    REQUIRE(loop.next_confirmation(confirmed));
    CHECK(confirmed.handed_over_ns == 4711);
    CHECK(confirmed.on_wire_ns >= before_ns - 1000);
    CHECK(confirmed.on_wire_ns <= read_clock_ns(CLOCK_MONOTONIC));
    CHECK(!loop.next_confirmation(confirmed));
    CHECK(loop.counts().sent == 2);
    CHECK(loop.counts().confirmed == 1);
}

TEST_CASE("bus: frames that are alike are confirmed one by one, each with the time at which it was handed over")
{
    can_socket loop(HAL_BUS_ROBOT, "vcan0", {0x20}, {0x80});
    for (int round = 0; round < 3; round++) { /* as SYNC, which has no number */
        for (const std::int64_t tick_ns : {1, 2, 3}) {
            const hal_frame sync{tick_ns, 0x80, HAL_BUS_ROBOT, 0, 0, 0, {}};
            REQUIRE(loop.send(sync) == HAL_OK);
        }
        drain(loop);
        can_confirmation confirmed;
        for (const std::int64_t tick_ns : {1, 2, 3}) {
            REQUIRE(loop.next_confirmation(confirmed));
            CHECK(confirmed.handed_over_ns == tick_ns);
        }
        CHECK(!loop.next_confirmation(confirmed));
    }
}

TEST_CASE(
    "bus: what was sent to a controller off the bus, or right after its restart, is not confirmed by later frames")
{
    can_socket loop(HAL_BUS_ROBOT, "vcan0", {0x20}, {0x80});
    can_socket controller(HAL_BUS_ROBOT, "vcan0", {});
    const auto send_sync = [&](std::int64_t tick_ns) {
        REQUIRE(loop.send({tick_ns, 0x80, HAL_BUS_ROBOT, 0, 0, 0, {}}) == HAL_OK);
    };
    REQUIRE(controller.send(frame_of(CAN_ERR_FLAG | CAN_ERR_BUSOFF)) == HAL_OK);
    CHECK(drain(loop).size() == 1);
    for (const std::int64_t tick_ns : {1, 2, 3}) { /* taken by the kernel, and never on the wire */
        send_sync(tick_ns);
    }
    loop.flush();
    REQUIRE(controller.send(frame_of(CAN_ERR_FLAG | CAN_ERR_RESTARTED)) == HAL_OK);
    CHECK(drain(loop).size() == 1);
    send_sync(4); /* the controller is there again, the kernel's queue not yet */
    loop.flush();
    can_confirmation confirmed;
    send_sync(5); /* says that frames pass */
    drain(loop);
    CHECK(!loop.next_confirmation(confirmed));
    send_sync(6);
    drain(loop);
    REQUIRE(loop.next_confirmation(confirmed));
    CHECK(confirmed.handed_over_ns == 6);
    CHECK(!loop.next_confirmation(confirmed));
}

TEST_CASE("bus: error frames are flagged and counted for what they say")
{
    can_socket listener(HAL_BUS_SENSOR, "vcan0", {id});
    can_socket controller(HAL_BUS_SENSOR, "vcan0", {});
    const std::uint8_t overflow = CAN_ERR_CRTL_RX_OVERFLOW;
    const std::uint8_t passive = CAN_ERR_CRTL_TX_PASSIVE;
    for (const hal_frame &frame :
         {frame_of(CAN_ERR_FLAG | CAN_ERR_CRTL, 0, overflow), frame_of(CAN_ERR_FLAG | CAN_ERR_CRTL, 0, passive),
          frame_of(CAN_ERR_FLAG | CAN_ERR_BUSOFF), frame_of(CAN_ERR_FLAG | CAN_ERR_RESTARTED)}) {
        REQUIRE(controller.send(frame) == HAL_OK);
    }
    const std::vector<hal_frame> frames = drain(listener);
    REQUIRE(frames.size() == 4);
    for (const hal_frame &frame : frames) {
        CHECK((frame.flags & HAL_FRAME_ERROR) != 0);
    }
    CHECK((frames[1].flags & HAL_FRAME_BUS_OFF) == 0);
    CHECK((frames[2].flags & HAL_FRAME_BUS_OFF) != 0);
    CHECK(listener.counts().controller_lost == 1);
    CHECK(listener.counts().error_passive == 1);
    CHECK(listener.counts().bus_off == 1);
    CHECK(listener.counts().restarted == 1);
}

TEST_CASE("bus: what the socket's buffer could not hold is counted, frame by frame")
{
    can_socket listener(HAL_BUS_SENSOR, "vcan0", {id});
    can_socket talker(HAL_BUS_SENSOR, "vcan0", {});
    constexpr int flood = 2000;
    std::uint64_t sent = 0;
    std::uint64_t received = 0;
    for (int round = 0; round < 2; round++) {
        for (int i = 0; i < flood; i++) {
            sent += talker.send(frame_of(id)) == HAL_OK;
        }
        while (const std::size_t some = drain(listener).size()) {
            CHECK(some <= 64); /* bounded: the rest is for the next tick */
            received += some;
        }
        sent += talker.send(frame_of(id)) == HAL_OK; /* brings the count of those lost before it */
        received += drain(listener).size();
    }
    CHECK(listener.counts().socket_lost > 0);
    CHECK(received + listener.counts().socket_lost == sent);
    CHECK(sent + talker.counts().not_sent == 2 * (flood + 1));
}

TEST_CASE("bus: an interface that is down is a controller off the bus, once; up again, frames pass again")
{
    can_socket loop(HAL_BUS_ROBOT, "vcan1", {id});
    can_socket other(HAL_BUS_ROBOT, "vcan1", {});
    REQUIRE(other.send(frame_of(id)) == HAL_OK);
    REQUIRE(set_up("vcan1", false));
    CHECK(loop.send(frame_of(0x10)) == HAL_NO_BUFFER);
    CHECK(loop.send(frame_of(0x10)) == HAL_NO_BUFFER);
    const std::vector<hal_frame> frames = drain(loop);
    REQUIRE(frames.size() == 2);
    CHECK(frames[0].flags == (HAL_FRAME_ERROR | HAL_FRAME_BUS_OFF));
    CHECK(frames[1].flags == 0); /* what had come before */
    CHECK(loop.send(frame_of(0x10)) == HAL_NO_BUFFER);
    CHECK(loop.counts().down == 1);
    CHECK(loop.counts().not_sent == 3);

    REQUIRE(set_up("vcan1", true));
    drain(loop);
    drain(other);
    CHECK(loop.send(frame_of(0x10)) == HAL_OK);
    REQUIRE(other.send(frame_of(id)) == HAL_OK);
    CHECK(drain(loop).size() == 1);
}

TEST_CASE("bus: each time that the interface goes down is told, on a bus as well that nothing is sent on")
{
    can_socket sensor(HAL_BUS_SENSOR, "vcan1", {id});
    can_socket other(HAL_BUS_SENSOR, "vcan1", {});
    for (std::uint64_t times = 1; times <= 3; times++) {
        CAPTURE(times);
        REQUIRE(set_up("vcan1", false));
        std::vector<hal_frame> frames = drain(sensor);
        REQUIRE(frames.size() == 1);
        CHECK(frames[0].flags == (HAL_FRAME_ERROR | HAL_FRAME_BUS_OFF));
        CHECK(sensor.counts().down == times);

        REQUIRE(set_up("vcan1", true));
        drain(other);
        REQUIRE(other.send(frame_of(id)) == HAL_OK);
        frames = drain(sensor);
        REQUIRE(frames.size() == 1);
        CHECK(frames[0].flags == 0);
    }
}

TEST_CASE("bus: a frame that finds the transmit queue full is dropped at once and never sent")
{
    can_socket loop(HAL_BUS_ROBOT, "can0", {});
    can_socket listener(HAL_BUS_ROBOT, "can2", {id});
    constexpr std::uint8_t burst = 40; /* the queue has room for 10 */
    std::vector<bool> was_sent;
    const sched_param above_the_interrupts{80};
    const sched_param ordinary{};
    REQUIRE(sched_setscheduler(0, SCHED_FIFO, &above_the_interrupts) == 0);
    for (std::uint8_t i = 0; i < burst; i++) {
        was_sent.push_back(loop.send(frame_of(id, i)) == HAL_OK);
    }
    REQUIRE(sched_setscheduler(0, SCHED_OTHER, &ordinary) == 0);
    CHECK(loop.counts().not_sent > 0);
    CHECK(loop.counts().sent + loop.counts().not_sent == burst);
    usleep(100000);
    const std::vector<hal_frame> frames = drain(listener);
    CHECK(!frames.empty());
    for (const hal_frame &frame : frames) {
        CHECK((frame.flags != 0 || was_sent[frame.data[0]]));
    }
    CHECK(loop.send(frame_of(id)) == HAL_OK);
}

} // namespace berth
