/* One side of a CANopen bus for a peer in another process: either the loop's firmware as master, or the simulated
 * drive. In virtual time and lockstep, so that nothing depends on how fast the peer is.
 *
 *   peer loop RIG [KEY=VALUE...]     frames of the loop out, frames of a drive in
 *   peer drive RIG [KEY=VALUE...]    frames of the simulated rig out, frames of a master in
 *
 * Standard output and input carry `struct can_frame` as SocketCAN has it (identifier, length, 3 bytes, data: 16
 * bytes). Each tick: frames out and a mark out, then frames in and a mark in. A mark has the identifier 0xffffffff;
 * out it carries a state, in a request. Ends with its input. */
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "../../firmware/cia402_text.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/virtual_rig.h"
#include "../unit/tick_builder.h"

namespace
{

constexpr std::uint32_t mark_id = 0xffffffff;
constexpr std::uint32_t remote_flag = 0x40000000; /* CAN_RTR_FLAG */

struct wire_frame {
    std::uint32_t id;
    std::uint8_t length;
    std::uint8_t padding[3];
    std::uint8_t data[8];
};
static_assert(sizeof(wire_frame) == 16, "struct can_frame");

void put(std::uint32_t id, std::uint8_t length, const std::uint8_t *data)
{
    wire_frame frame{id, length, {}, {}};
    std::memcpy(frame.data, data, sizeof frame.data);
    std::fwrite(&frame, sizeof frame, 1, stdout);
}

void put_mark(const std::uint8_t (&state)[8])
{
    put(mark_id, 8, state);
    std::fflush(stdout);
}

/* Frames up to the mark, whose first byte goes to `request`; false at the end of input. */
bool get_tick(std::vector<hal_frame> &frames, int &request)
{
    frames.clear();
    wire_frame frame{};
    while (std::fread(&frame, sizeof frame, 1, stdin) == 1) {
        if (frame.id == mark_id) {
            request = frame.data[0];
            return true;
        }
        hal_frame received{0, frame.id, HAL_BUS_ROBOT, frame.length, 0, 0, {}};
        std::memcpy(received.data, frame.data, sizeof received.data);
        frames.push_back(received);
    }
    return false;
}

void put(const hal_frame &frame)
{
    put(frame.id | ((frame.flags & HAL_FRAME_REMOTE) ? remote_flag : 0u), frame.length, frame.data);
}

/* What is wrong with the drive, in words, on standard error. */
void say_trouble(const cia402 &drive)
{
    char text[CIA402_TEXT_BYTES_MAX];
    cia402_trouble_text(static_cast<cia402_trouble>(drive.trouble), drive.setup.step, drive.error, text);
    std::fputs(text, stderr);
}

/* The firmware, with a sensor that feels nothing and an operator who asks what the peer wants. */
void run_loop(const berth::rig &rig)
{
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &rig.firmware);
    const std::int64_t period_ns = config_period_ns(&rig.firmware);
    std::vector<hal_frame> frames;
    int request = OPERATOR_NONE;
    bench::patient_operator person;
    for (std::int64_t index = 0;; index++) {
        const std::int64_t now_ns = index * period_ns;
        const auto counter = static_cast<std::uint8_t>(index);
        tick_input in{};
        tick_output out{};
        in.tick = {index, now_ns, now_ns, 0, 0};
        in.enable = HAL_LEVEL_NOT_WIRED;
        in.frames[in.frame_count++] = bench::force_frame(0.0, counter, now_ns);
        in.frames[in.frame_count++] = bench::motion_frame(
            0.0, 0.0, person.asks(request, static_cast<supervisor_state>(app->supervisor.state)), counter, now_ns);
        for (hal_frame &frame : frames) {
            frame.time_ns = now_ns;
            if (in.frame_count < TICK_FRAMES_IN_MAX) {
                in.frames[in.frame_count++] = frame;
            }
        }
        app_step(app.get(), &in, &out);
        for (std::uint32_t i = 0; i < out.frame_count; i++) {
            put(out.frames[i]);
        }
        const std::int64_t command_nm = std::llround(1e9 * app->recorder.tick.command_position_m);
        std::uint8_t state[8] = {static_cast<std::uint8_t>(app->supervisor.state),
                                 static_cast<std::uint8_t>(app->supervisor.stop_cause),
                                 app->recorder.tick.drive_trouble, 0};
        for (int i = 0; i < 4; i++) {
            state[4 + i] = static_cast<std::uint8_t>(command_nm >> (8 * i));
        }
        put_mark(state);
        if (!get_tick(frames, request)) {
            say_trouble(app->robot_channel.drive);
            return;
        }
    }
}

/* The simulated rig; a mark carries where the robot really is, in m. */
void run_drive(const berth::rig &rig)
{
    berth::virtual_rig virtual_rig(rig);
    const std::int64_t period_ns = config_period_ns(&rig.firmware);
    std::vector<hal_frame> frames;
    int request = 0;
    for (std::int64_t index = 0;; index++) {
        virtual_rig.advance_to(index * period_ns);
        hal_frame frame;
        while (virtual_rig.bus(HAL_BUS_SENSOR).receive(virtual_rig.now_ns(), frame)) {
        }
        while (virtual_rig.bus(HAL_BUS_ROBOT).receive(virtual_rig.now_ns(), frame)) {
            put(frame.id, frame.length, frame.data);
        }
        const double position_m = virtual_rig.truth().robot_position_m;
        std::uint8_t state[8];
        std::memcpy(state, &position_m, sizeof state);
        put_mark(state);
        if (!get_tick(frames, request)) {
            return;
        }
        virtual_rig.set_robot_fault(request != 0);
        for (hal_frame &sent : frames) {
            sent.time_ns = virtual_rig.now_ns();
            virtual_rig.receive_from_loop(sent);
        }
    }
}

} // namespace

int main(int argc, char **argv)
{
    const std::string role = argc > 2 ? argv[1] : "";
    if (role != "loop" && role != "drive") {
        std::fprintf(stderr, "usage: %s loop|drive RIG [KEY=VALUE...]\n", argv[0]);
        return 2;
    }
    try {
        const berth::rig rig = berth::load_rig(argv[2], std::vector<std::string>(argv + 3, argv + argc));
        (role == "loop" ? run_loop : run_drive)(rig);
    } catch (const berth::input_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
    return 0;
}
