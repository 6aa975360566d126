#include "sim_hal.h"

#include <cstdio>
#include <utility>

#include "../../firmware/app.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/rig_log.h"
#include "rig_record.h"
#include "wake_histogram.h"

struct hal {
    hal(const berth::rig &rig, berth::sim_options given);

    berth::virtual_rig rig;
    berth::wake_lateness lateness;
    berth::log_file log;
    berth::sim_options options;
    std::int64_t period_ns;
    std::int64_t tick_count;
    std::int64_t next_tick = 0;
    std::int64_t emergency_stop_ns;
    std::int64_t enable_off_ns;
    uint8_t forced[HAL_LINE_COUNT] = {0, 0, 0, 0}; /* 0: by schedule, else level + 1 */
    uint8_t outputs[HAL_LINE_COUNT] = {0, 0, 0, 0};
    bool refuses_frames = false;
};

namespace berth
{

namespace
{

constexpr std::int64_t progress_every_ticks = 4096;

log_header header_of(const rig &rig, const sim_options &options)
{
#define FORMAT_FIELD(type, name) #type " " #name ";"
    log_header header = rig_log_header(options.told ? *options.told : rig);
    header.topics.push_back({ulog_rig_id, "rig", "rig:" RIG_RECORD_FIELDS(FORMAT_FIELD)});
    if (!options.robot.empty()) {
        header.infos.emplace_back("berth_robot", options.robot);
    }
    return header;
}

void record_truth(struct hal &hal, std::int64_t now_ns)
{
    const rig_truth truth = hal.rig.truth();
    const rig_message message{sizeof(rig_message) - 3,
                              'D',
                              ulog_rig_id,
                              static_cast<std::uint64_t>(now_ns) / 1000,
                              truth.robot_position_m,
                              truth.robot_velocity_m_per_s,
                              truth.object_position_m,
                              truth.object_velocity_m_per_s,
                              truth.spring_force_N,
                              truth.measured_force_N};
    hal.log.push(&message, sizeof message);
}

} // namespace

struct hal *sim_open(const rig &rig, sim_options options)
{
    return new struct hal(rig, std::move(options));
}

virtual_rig &sim_rig(struct hal *hal)
{
    return hal->rig;
}

log_file &sim_log(struct hal *hal)
{
    return hal->log;
}

uint8_t sim_output(const struct hal *hal, hal_line line)
{
    return hal->outputs[line];
}

void sim_refuse_frames(struct hal *hal, bool refuses)
{
    hal->refuses_frames = refuses;
}

void sim_set_input(struct hal *hal, hal_line line, uint8_t level)
{
    hal->forced[line] = static_cast<uint8_t>(level + 1);
}

} // namespace berth

hal::hal(const berth::rig &wanted, berth::sim_options given)
    : rig(wanted), lateness(berth::load_wake_histogram(wanted), wanted.run.seed),
      log(given.log_path, berth::header_of(wanted, given)), options(std::move(given)),
      period_ns(config_period_ns(&wanted.firmware)), tick_count(berth::event_ns(wanted.run.duration_s) / period_ns),
      emergency_stop_ns(berth::event_ns(wanted.run.emergency_stop_s)),
      enable_off_ns(berth::event_ns(wanted.run.enable_off_s))
{
}

extern "C" {

enum hal_status hal_open(struct hal **hal, int argc, char **argv, struct app_config *config)
{
    *hal = nullptr;
    try {
        if (argc < 2 || argc > 3) {
            throw berth::input_error(std::string("usage: ") + argv[0] + " RIG [LOG]");
        }
        const berth::rig rig = berth::load_rig(argv[1]);
        *config = rig.firmware;
        berth::sim_options options;
        options.log_path = argc == 3 ? argv[2] : "";
        *hal = berth::sim_open(rig, options);
    } catch (const berth::input_error &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return HAL_INVALID;
    }
    return HAL_OK;
}

enum hal_status hal_close(struct hal *hal)
{
    hal->log.drain();
    const bool is_complete = hal->log.dropped_records() == 0;
    if (!is_complete) {
        std::fprintf(stderr, "the log is incomplete: %llu records dropped (%s)\n",
                     static_cast<unsigned long long>(hal->log.dropped_records()), hal->log.trouble());
    }
    delete hal;
    return is_complete ? HAL_OK : HAL_INVALID;
}

enum hal_status hal_wait_tick(struct hal *hal, struct hal_tick *tick)
{
    if (hal->next_tick >= hal->tick_count) {
        return HAL_END;
    }
    const std::int64_t scheduled_ns = hal->next_tick * hal->period_ns;
    const std::int64_t woke_ns = scheduled_ns + hal->lateness.next_ns();
    hal->rig.advance_to(woke_ns);
    *tick = {hal->next_tick, scheduled_ns, woke_ns, 0, 0};
    if (hal->options.stop != nullptr && hal->options.stop->load(std::memory_order_relaxed)) {
        tick->stop = 1;
    }
    if (hal->options.progress && hal->next_tick % berth::progress_every_ticks == 0) {
        hal->options.progress(static_cast<double>(hal->next_tick) / static_cast<double>(hal->tick_count));
    }
    hal->next_tick++;
    berth::record_truth(*hal, woke_ns);
    hal->log.drain_if_due();
    return HAL_OK;
}

enum hal_status hal_can_receive(struct hal *hal, enum hal_bus bus, struct hal_frame *frame)
{
    return hal->rig.bus(bus).receive(hal->rig.now_ns(), *frame) ? HAL_OK : HAL_EMPTY;
}

enum hal_status hal_can_send(struct hal *hal, const struct hal_frame *frame)
{
    if (hal->refuses_frames) {
        return HAL_NO_BUFFER;
    }
    hal_frame sent = *frame;
    sent.time_ns = hal->rig.now_ns(); /* a late tick sends late */
    hal->rig.receive_from_loop(sent);
    return HAL_OK;
}

enum hal_status hal_gpio_get(struct hal *hal, enum hal_line line, uint8_t *level)
{
    if (hal->forced[line] != 0) {
        *level = static_cast<uint8_t>(hal->forced[line] - 1);
    } else if (line == HAL_LINE_EMERGENCY_STOP) {
        *level = hal->rig.now_ns() >= hal->emergency_stop_ns;
    } else { /* given after the first tick: what is on from the start does not count */
        *level = hal->next_tick > 1 && hal->rig.now_ns() < hal->enable_off_ns;
    }
    return HAL_OK;
}

enum hal_status hal_gpio_set(struct hal *hal, enum hal_line line, uint8_t level)
{
    hal->outputs[line] = level;
    return HAL_OK;
}

enum hal_status hal_record(struct hal *hal, const void *bytes, size_t size_bytes)
{
    return hal->log.push(bytes, size_bytes) ? HAL_OK : HAL_NO_BUFFER;
}
}
