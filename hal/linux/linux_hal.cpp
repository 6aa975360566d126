/* hal.h on real buses and lines. */
#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>

#include "../../firmware/can/berth_can.h"
#include "../../firmware/canopen.h"
#include "../../firmware/reception.h"
#include "../hal.h"
#include "../rig/rig_file.h"
#include "../rig/rig_log.h"
#include "can_link.h"
#include "can_socket.h"
#include "hardware_error.h"
#include "line_record.h"
#include "lines.h"
#include "live_sender.h"
#include "log_writer.h"
#include "loop_timing.h"
#include "machine.h"
#include "preflight.h"
#include "real_time.h"
#include "stage.h"
#include "stop_signals.h"
#include "tick_clock.h"
#include "watchdog.h"

/* In the order in which things are opened; closing goes backwards. */
struct hal {
    hal(const berth::rig &wanted, const berth::target_options &given, int argc, char **argv);

    berth::rig rig;
    berth::target_options options;
    berth::timing_setting timing_setting;
    berth::loop_timing timing;
    std::unique_ptr<berth::can_socket> buses[HAL_BUS_COUNT]; /* none: without buses */
    berth::lines lines;
    berth::real_time real_time;
    bool may_move;
    std::unique_ptr<berth::live_sender> live; /* null without --live; used by the thread of the log */
    berth::log_writer log;
    std::atomic<std::uint64_t> ticks{0};
    berth::watchdog watchdog;
    berth::stamp_clock stamps;
    std::optional<berth::tick_clock> clock; /* from the first tick on */
    std::int64_t end_ns;
    hal_tick tick{};
    bool was_pressed = false;    /* between two ticks */
    std::uint32_t last_force_id; /* with this frame a sample is whole */
    std::optional<std::int64_t> newest_force_ns;
};

namespace berth
{

namespace
{

/* A loop that is asked to stop leads the robot to rest first; one that cannot ends after this. */
constexpr std::int64_t rest_within_ns = 5 * NS_PER_S;

/* For interfaces that come up while the machine boots. */
constexpr std::chrono::seconds bus_patience{10};

/* As many as the kernel keeps. */
constexpr int edges_a_tick = 16;

target_rig wiring(const rig &rig, const target_options &options)
{
    target_rig target = rig.target;
    if (options.without_buses) {
        for (std::string *line : {&target.emergency_stop_line, &target.enable_line, &target.heartbeat_line,
                                  &target.tick_line, &target.fault_line}) {
            line->clear();
        }
    }
    return target;
}

using bus_pair = std::unique_ptr<can_socket>[HAL_BUS_COUNT];

log_header header_of(const rig &rig, const target_options &options, const real_time &real_time,
                     const bus_pair &buses)
{
#define FORMAT_FIELD(type, name) #type " " #name ";"
    log_header header = rig_log_header(rig);
    header.topics.push_back({ulog_line_id, "line", "line:" LINE_RECORD_FIELDS(FORMAT_FIELD)});
    for (auto &fact : facts_for_log(rig.target)) {
        header.infos.push_back(std::move(fact));
    }
    header.infos.emplace_back("berth_scheduling", real_time.is_real_time()
                                                      ? real_time.description()
                                                      : "not real-time: " + real_time.problem());
    for (const auto &bus : buses) {
        if (bus != nullptr) {
            header.infos.emplace_back(bus == buses[HAL_BUS_ROBOT] ? "berth_robot_stamps" : "berth_sensor_stamps",
                                      bus->stamps());
        }
    }
    header.infos.emplace_back("berth_without_realtime", options.without_realtime ? "allowed by option" : "refused");
    return header;
}

std::unique_ptr<live_sender> live_of(const rig &rig, const target_options &options)
{
    if (options.live_address.empty()) {
        return nullptr;
    }
    const auto run = static_cast<std::uint32_t>(read_clock_ns(CLOCK_REALTIME) / NS_PER_S);
    return std::make_unique<live_sender>(
        options.live_address, live_source{rig.name, config_hash(rig), config_period_ns(&rig.firmware), run});
}

/* The frame of each tick whose time on the wire is measured. */
std::uint32_t timed_id(const rig &rig)
{
    return rig.firmware.robot_channel.profile == ROBOT_PROFILE_CIA402 ? CANOPEN_SYNC_ID
                                                                      : BERTH_CAN_SETPOINT_FRAME_ID;
}

std::vector<std::uint32_t> ids_on(hal_bus bus, const app_config &config)
{
    std::vector<std::uint32_t> ids(RECEIVED_COUNT);
    ids.resize(reception_ids(&config, bus, ids.data()));
    return ids;
}

bool is_down(const std::string &interface)
{
    const std::optional<can_link> link = find_can_link(interface);
    return link && !link->is_up;
}

/* A bus that is down at the first tick would be a fault, which a person has to reset. */
void wait_until_up(const std::string &interface)
{
    if (!is_down(interface)) {
        return;
    }
    std::fprintf(stderr, "%s is down: waiting %d s for it\n", interface.c_str(),
                 static_cast<int>(bus_patience.count()));
    const auto patience_ends = std::chrono::steady_clock::now() + bus_patience;
    while (is_down(interface) && !stop_is_wanted()) {
        if (std::chrono::steady_clock::now() > patience_ends) {
            fail_hardware(interface + ": the interface is down", ENETDOWN, "berth-target --check says what to do");
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
}

std::unique_ptr<can_socket> open_bus(hal_bus bus, const rig &rig, const target_options &options)
{
    if (options.without_buses) {
        return nullptr;
    }
    const bool is_robot = bus == HAL_BUS_ROBOT;
    const std::string &interface = is_robot ? rig.target.robot_interface : rig.target.sensor_interface;
    const auto confirmed_ids = is_robot ? std::vector{timed_id(rig)} : std::vector<std::uint32_t>{};
    wait_until_up(interface);
    return std::make_unique<can_socket>(bus, interface, ids_on(bus, rig.firmware), confirmed_ids);
}

void note_confirmations(struct hal &hal)
{
    can_confirmation confirmation;
    while (hal.buses[HAL_BUS_ROBOT]->next_confirmation(confirmation)) {
        const std::int64_t on_wire_ns = confirmation.on_wire_ns - hal.clock->zero_ns();
        hal.timing.tick_to_wire.add(on_wire_ns - confirmation.handed_over_ns);
    }
}

void read_buses(struct hal &hal)
{
    if (hal.options.without_buses) {
        return;
    }
    hal.stamps.update();
    for (auto &bus : hal.buses) {
        bus->drain(hal.stamps);
    }
    note_confirmations(hal);
}

/* A press that is shorter than a tick is a press; of two edges in a row the kernel may tell the second only. Of a
 * contact that bounces without end, the next tick reads on. */
void read_edges(struct hal &hal)
{
    gpio_edge edge;
    hal.was_pressed = false;
    for (int i = 0; i < edges_a_tick && hal.lines.next_edge(rig_line::emergency_stop, edge); i++) {
        hal.was_pressed = true;
        const line_message message{sizeof(line_message) - 3,
                                   'D',
                                   ulog_line_id,
                                   static_cast<std::uint64_t>(hal.tick.scheduled_ns) / 1000,
                                   edge.time_ns - hal.clock->zero_ns(),
                                   HAL_LINE_EMERGENCY_STOP,
                                   static_cast<std::uint8_t>(edge.level)};
        hal.log.push(&message, sizeof message);
    }
}

/* From the second tick on: what the one before has cost. */
void end_tick(struct hal &hal)
{
    if (hal.clock) {
        hal.lines.set(rig_line::tick, 0);
        const std::int64_t now_ns = read_clock_ns(CLOCK_MONOTONIC) - hal.clock->zero_ns();
        hal.timing.execution.add(now_ns - hal.tick.woke_ns);
        if (hal.newest_force_ns) {
            hal.timing.force_age.add(hal.tick.woke_ns - *hal.newest_force_ns);
        }
        return;
    }
    hal.clock.emplace(config_period_ns(&hal.rig.firmware));
}

/* What the kernel kept from before the run is not of it. */
bool receive(struct hal &hal, hal_bus bus, hal_frame &frame)
{
    const std::int64_t zero_ns = hal.clock->zero_ns();
    bool is_received = false;
    do {
        is_received = hal.buses[bus] != nullptr && hal.buses[bus]->receive(zero_ns + hal.tick.woke_ns, frame);
    } while (is_received && frame.time_ns < zero_ns);
    frame.time_ns -= zero_ns;
    return is_received;
}

enum hal_status open_hal(struct hal **hal, int argc, char **argv, struct app_config *config)
{
    const target_options options = parse_options(argc, argv);
    if (options.is_done) {
        return HAL_END;
    }
    const rig rig = target_rig_of(options);
    if (options.check_only) {
        return print_preflight(rig, options.live_address) ? HAL_END : HAL_HARDWARE;
    }
    *config = rig.firmware;
    catch_stop_signals();
    *hal = new struct hal(rig, options, argc, argv);
    return HAL_OK;
}

} // namespace

} // namespace berth

hal::hal(const berth::rig &wanted, const berth::target_options &given, int argc, char **argv)
    : rig(wanted), options(given), buses{berth::open_bus(HAL_BUS_ROBOT, wanted, given),
                                         berth::open_bus(HAL_BUS_SENSOR, wanted, given)},
      lines(berth::wiring(wanted, given)), real_time(wanted.target),
      may_move(real_time.is_real_time() || given.without_realtime), live(berth::live_of(wanted, given)),
      log(given.log_path.empty() ? wanted.target.log_path : given.log_path,
          berth::header_of(wanted, given, real_time, buses), real_time.other_cpus(), given.rotation,
          live ? [this](const std::uint8_t *bytes, std::size_t size_bytes) { live->take(bytes, size_bytes); }
               : berth::log_file::witness()),
      watchdog(wanted.target.watchdog_device, ticks, real_time.other_cpus()),
      end_ns(given.until_stopped || wanted.run.duration_s > 9e9 ? INT64_MAX - berth::rest_within_ns
                                                                : ns_from_ms(1e3 * wanted.run.duration_s)),
      last_force_id(berth::ids_on(HAL_BUS_SENSOR, wanted.firmware).back())
{
    if (!may_move) {
        std::fprintf(stderr,
                     "no real-time scheduling: motion stays disabled, as if the enable line were off\n"
                     "  %s\n  or give --without-realtime to move all the same\n",
                     real_time.problem().c_str());
    }
    timing_setting = {berth::command_line(argc, argv),
                      real_time.is_real_time() ? real_time.description() : real_time.problem(),
                      wanted.target.cpu,
                      real_time.is_real_time() ? wanted.target.priority : 0,
                      config_period_ns(&wanted.firmware) / 1000,
                      berth::date_now()};
    if (!given.jitter_path.empty()) {
        berth::write_timing(given.jitter_path, timing, timing_setting); /* one that cannot be is said now */
    }
}

extern "C" {

enum hal_status hal_open(struct hal **hal, int argc, char **argv, struct app_config *config)
{
    *hal = nullptr;
    try {
        return berth::open_hal(hal, argc, argv, config);
    } catch (const berth::input_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return HAL_INVALID;
    } catch (const berth::hardware_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return HAL_HARDWARE;
    }
}

enum hal_status hal_close(struct hal *hal)
{
    const std::unique_ptr<struct hal> closing(hal);
    enum hal_status status = HAL_OK;
    hal->log.finish();
    if (hal->live) {
        std::fprintf(stderr, "live: %llu samples sent, %llu not taken by the network\n",
                     static_cast<unsigned long long>(hal->live->sent()),
                     static_cast<unsigned long long>(hal->live->unsent()));
    }
    const berth::log_file &log = hal->log.file();
    if (log.dropped_records() > 0) {
        std::fprintf(stderr, "the log is incomplete: %llu records dropped (%s)\n",
                     static_cast<unsigned long long>(log.dropped_records()), log.trouble());
        status = HAL_INVALID;
    }
    for (const auto &bus : hal->buses) {
        if (bus != nullptr) {
            berth::print_trouble(*bus);
        }
    }
    if (hal->timing.wake_up.count() > 0) {
        berth::print_timing(hal->timing);
    }
    try {
        berth::note_stage(hal->options);
        if (hal->options.jitter_path.empty()) {
            return status;
        }
        berth::write_timing(hal->options.jitter_path, hal->timing, hal->timing_setting);
    } catch (const berth::input_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        status = HAL_INVALID;
    }
    return status;
}

enum hal_status hal_wait_tick(struct hal *hal, struct hal_tick *tick)
{
    if (hal->tick.scheduled_ns >= hal->end_ns + berth::rest_within_ns) {
        return HAL_END;
    }
    berth::end_tick(*hal);
    std::int64_t late_ns = 0;
    try {
        hal->tick = hal->clock->wait(&late_ns);
    } catch (const berth::hardware_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return HAL_HARDWARE;
    }
    hal->lines.set(berth::rig_line::tick, 1);
    hal->timing.wake_up.add(late_ns);
    hal->timing.overruns += hal->tick.missed;
    hal->ticks.fetch_add(1, std::memory_order_relaxed);
    if (berth::stop_is_wanted()) {
        hal->end_ns = std::min(hal->end_ns, hal->tick.scheduled_ns);
    }
    hal->tick.stop = hal->tick.scheduled_ns >= hal->end_ns;
    berth::read_buses(*hal);
    berth::read_edges(*hal);
    *tick = hal->tick;
    return HAL_OK;
}

enum hal_status hal_can_receive(struct hal *hal, enum hal_bus bus, struct hal_frame *frame)
{
    if (!hal->clock || !berth::receive(*hal, bus, *frame)) {
        return HAL_EMPTY;
    }
    if (frame->id == hal->last_force_id && frame->flags == 0) {
        hal->newest_force_ns = frame->time_ns;
    }
    return HAL_OK;
}

enum hal_status hal_can_send(struct hal *hal, const struct hal_frame *frame)
{
    berth::can_socket *const bus = hal->buses[frame->bus].get();
    return bus == nullptr ? HAL_OK : bus->send(*frame);
}

enum hal_status hal_gpio_get(struct hal *hal, enum hal_line line, uint8_t *level)
{
    if (line == HAL_LINE_EMERGENCY_STOP) {
        const bool is_wired = hal->lines.is_wired(berth::rig_line::emergency_stop);
        *level = hal->was_pressed || (is_wired && hal->lines.get(berth::rig_line::emergency_stop, 1));
    } else {
        const bool is_wired = hal->lines.is_wired(berth::rig_line::enable);
        *level = !hal->may_move ? 0 : is_wired ? hal->lines.get(berth::rig_line::enable, 0) : HAL_LEVEL_NOT_WIRED;
    }
    return HAL_OK;
}

enum hal_status hal_gpio_set(struct hal *hal, enum hal_line line, uint8_t level)
{
    hal->lines.set(line == HAL_LINE_FAULT ? berth::rig_line::fault : berth::rig_line::heartbeat, level);
    return HAL_OK;
}

enum hal_status hal_record(struct hal *hal, const void *bytes, size_t size_bytes)
{
    return hal->log.push(bytes, size_bytes) ? HAL_OK : HAL_NO_BUFFER;
}
}
