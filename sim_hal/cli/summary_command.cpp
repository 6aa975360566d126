#include <cstdio>

#include "../../hal/log_file.h"
#include "../hil/rig_record.h"
#include "../log/ulog_reader.h"
#include "commands.h"
#include "log_condition.h"
#include "log_result.h"
#include "robot_choice.h"

namespace berth
{

run_result read_result(const std::string &path, rig &rig, log_state &state)
{
    ulog_reader log(path);
    log.stop_at_damage();
    rig = log.recorded_rig();
    run_result result(rig);
    result.motors.is_told = log.knows_motors();
    tick_record last{};
    arm_record arm{};                     /* of a tick, before it */
    std::optional<double> spring_force_N; /* of a tick, before it; a real rig's is not known */
    std::int64_t frames_received = 0;
    std::int64_t frames_of_tick = 0; /* they come before it */
    std::int64_t next_index = 0;
    const bool is_later_part = log.infos().count(log_part_key) != 0;
    std::uint16_t id = 0;
    std::string_view bytes;
    while (log.next(id, bytes)) {
        if (id == ULOG_FRAME_ID) {
            frames_of_tick += record_as<frame_record>(bytes).direction == 0;
        } else if (id == ULOG_ARM_ID) {
            arm = record_as<arm_record>(bytes);
        } else if (id == ulog_rig_id && bytes.size() == sizeof(rig_values)) {
            spring_force_N = record_as<rig_values>(bytes).spring_force_N;
        } else if (id == ULOG_TICK_ID) {
            last = record_as<tick_record>(bytes);
            note_tick(result, rig, last, arm, spring_force_N);
            spring_force_N.reset();
            frames_received += frames_of_tick;
            frames_of_tick = 0;
            if (state.ticks == 0 && is_later_part) {
                next_index = last.index - last.missed_ticks;
            }
            state.missing_ticks += last.index - last.missed_ticks - next_index;
            next_index = last.index + 1;
            state.ticks++;
        }
    }
    conclude(result, rig, last);
    result.frames_accepted = frames_received - result.frames_rejected - result.error_frames;
    result.log = path;
    if (const auto robot = log.infos().find("berth_robot"); robot != log.infos().end()) {
        check_recorded_robot(robot->second, path);
        result.robot = robot->second;
    }
    const auto recorded_version = log.infos().find("ver_sw");
    result.version = recorded_version != log.infos().end() ? recorded_version->second : "unknown";
    state.condition = log.condition();
    return result;
}

namespace
{

/* Heights of the free motion's oscillation over the time of the run, and the fitted exponential through them. */
nlohmann::json envelope_as_json(const run_result &result, double period_s)
{
    const auto run_time_s = [&](double free_motion_s) {
        const auto sample = static_cast<std::size_t>(free_motion_s / period_s);
        return period_s * static_cast<double>(result.motion.longest().tick[sample]) +
               (free_motion_s - period_s * static_cast<double>(sample));
    };
    nlohmann::json times = nlohmann::json::array();
    nlohmann::json heights = nlohmann::json::array();
    for (const oscillation_height &height : oscillation_heights(result.motion.longest().position_m, period_s)) {
        times.push_back(run_time_s(height.time_s));
        heights.push_back(height.value);
    }
    nlohmann::json json = {{"time_s", times}, {"height_m", heights}};
    if (result.evidence.growth) {
        json["fit_from_s"] = run_time_s(result.evidence.growth->from_s);
        json["fit_to_s"] = run_time_s(result.evidence.growth->to_s);
        json["fit_height_from_m"] = result.evidence.growth->height_from;
    }
    return json;
}

} // namespace

int summary_command(const std::string &path, bool json)
{
    rig rig;
    log_state state;
    const run_result result = read_result(path, rig, state);
    const int exit_code = state.condition.damage ? exit_damaged : 0;
    print_damage(path, state.condition, state.ticks);
    if (json) {
        nlohmann::json object = as_json(result, rig);
        object["missing_ticks"] = state.missing_ticks;
        object.update(as_json(state.condition));
        object["envelope"] = envelope_as_json(result, config_period_s(&rig.firmware));
        print_json(object);
        return exit_code;
    }
    print_summary(result, rig);
    if (state.condition.is_cut) {
        std::printf("the file is cut: told up to the last whole tick%s\n", time_of_end(state.condition).c_str());
    }
    if (!state.condition.has_checksums) {
        std::printf("the log has no checksums: nobody can know whether it is damaged\n");
    }
    if (state.missing_ticks > 0) {
        std::printf("%lld ticks are missing in the log\n", static_cast<long long>(state.missing_ticks));
    }
    return exit_code;
}

} // namespace berth
