#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "../../firmware/loop.h"
#include "../../hal/version.h"
#include "../hil/manipulator_stand_in.h"
#include "../hil/profile.h"
#include "../hil/sim_hal.h"
#include "../hil/wake_histogram.h"
#include "../log/candump.h"
#include "../stability/arm_loop.h"
#include "commands.h"
#include "robot_choice.h"
#include "run_folder.h"
#include "run_result.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

constexpr int exit_input = 2;
constexpr int exit_signal = 128; /* plus the number of the signal that ended the run, as shells have it */

std::atomic<bool> stop_wanted{false};
volatile std::sig_atomic_t stop_signal = 0;

extern "C" void on_interrupt(int signal)
{
    stop_signal = signal;
    stop_wanted.store(true, std::memory_order_relaxed);
}

void make_folder(const std::filesystem::path &path)
{
    std::error_code error;
    std::filesystem::create_directories(path, error);
    if (error) {
        throw input_error(path.string() + ": the folder for the log cannot be made (" + error.message() +
                          "); choose another with --out");
    }
}

void show_progress(double share)
{
    static const char bar[] = "########################################";
    std::fprintf(stderr, "\r[%-40.*s] %3.0f %%", static_cast<int>(40.0 * share), bar, 100.0 * share);
}

void end_progress()
{
    std::fprintf(stderr, "\r%48s\r", "");
}

run_result run_loop(const rig &rig, const sim_options &options, answer_scope scope)
{
    const auto app = std::make_unique<struct app>();
    run_result result(rig);
    const std::unique_ptr<struct hal, hal_status (*)(struct hal *)> open_hal(sim_open(rig, options), hal_close);
    struct hal *hal = open_hal.get();
    app_start(app.get(), &rig.firmware);
    manipulator_stand_in manipulator(rig);

    const auto begin = std::chrono::steady_clock::now();
    while (app->supervisor.state != SUPERVISOR_STOPPED && loop_tick(hal, app.get()) == HAL_OK) {
        note_tick(result, rig, app->recorder.tick, app->arm_record, sim_rig(hal).truth().spring_force_N);
        manipulator.replace(*app);
    }
    sim_log(hal).drain();
    result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();

    conclude(result, rig, app->recorder.tick, scope);
    result.frames_accepted = app->reception.counts.accepted;
    result.version = version();
    result.dropped_records = sim_log(hal).dropped_records();
    return result; /* closing says what is wrong with the log */
}

/* The frames as text beside a complete log; what an earlier run left there is not of this one. */
bool write_candumps(run_result &result)
{
    for (const std::string &path : candump_paths(result.log)) {
        std::remove(path.c_str());
    }
    if (result.dropped_records > 0) {
        return false;
    }
    try {
        result.candumps = export_candump(result.log);
    } catch (const input_error &error) {
        std::fprintf(stderr, "berth: %s\n", error.what());
        return false;
    }
    return true;
}

/* Orders come by their times, whether the run lasts until then or not. */
void tell_late_orders(const rig &rig)
{
    const double end_s = rig.run.duration_s - rig.run.release_s;
    for (const operator_order &order : rig.orders) {
        if (order.at_s >= end_s) {
            std::fprintf(stderr,
                         "berth: %s: orders.at_s = %g: is after the run's end, at %g s from run.release_s on, and "
                         "never given; run.duration_s makes it longer\n",
                         rig.name.c_str(), order.at_s, end_s);
        }
    }
}

chosen_rig rig_of(run_arguments arguments)
{
    std::vector<std::string> &overrides = arguments.overrides;
    if (!arguments.profile_file.empty()) {
        overrides.push_back("profile.kind=file");
        overrides.push_back("profile.file=" + arguments.profile_file);
    }
    if (!arguments.jitter_file.empty()) {
        overrides.push_back("run.lateness_file=" + arguments.jitter_file);
    }
    return choose_rig(arguments);
}

} // namespace

int run_command(const run_arguments &arguments)
{
    const chosen_rig chosen = rig_of(arguments);
    const rig &rig = chosen.rig;
    if (arguments.print_config) {
        if (chosen.robot) {
            std::printf("# robot %s\n", robot_sentence(robot_as_json(chosen)).c_str());
        }
        std::fputs(print_config(rig).c_str(), stdout);
        return 0;
    }
    refuse_unstated(rig, arguments.rig);
    refuse_unstable_steps(rig);
    tell_late_orders(rig);
    sim_options options;
    if (chosen.robot) {
        options.robot = robot_as_text(chosen);
    }
    options.stop = &stop_wanted;
    /* Before the output folder is made: an error leaves no empty one. */
    if (const std::string note = left_out_note(load_wake_histogram(rig)); !note.empty()) {
        std::fprintf(stderr, "berth: %s: %s; measure again with a longer --histogram\n",
                     rig.run.lateness_file.c_str(), note.c_str());
    }
    const profile profile(rig);
    if (!profile.note().empty()) {
        std::fprintf(stderr, "berth: %s\n", profile.note().c_str());
    }
    const bool is_kept = !arguments.no_log && arguments.out_folder.empty();
    if (!arguments.no_log) {
        const std::string folder = is_kept ? make_run_folder(rig.name) : arguments.out_folder;
        make_folder(folder);
        options.log_path = std::filesystem::path(folder) / (rig.name + ".ulg");
    }
    const bool shows_progress = !arguments.json && isatty(STDERR_FILENO);
    if (shows_progress) {
        options.progress = show_progress;
    }
    std::signal(SIGINT, on_interrupt);
    std::signal(SIGTERM, on_interrupt);
    std::signal(SIGXFSZ, SIG_IGN); /* a file size limit is a full disk: write() says so */

    run_result result =
        run_loop(rig, options, arguments.no_advice ? answer_scope::verdict_alone : answer_scope::whole);
    if (shows_progress) {
        end_progress();
    }
    result.log = options.log_path;
    result.robot = robot_as_text(chosen);
    const bool is_logged = arguments.no_log || write_candumps(result);
    if (is_kept) {
        result.runs_page = keep_run(std::filesystem::path(result.log).parent_path().string(), as_json(result, rig),
                                    rig, arguments.keep);
    }
    if (arguments.json) {
        print_json(as_json(result, rig));
    } else {
        print_summary(result, rig);
    }
    if (stop_wanted) {
        std::fprintf(stderr, "berth: interrupted; the robot was brought to rest%s\n",
                     is_logged ? " and the log is complete" : "");
        return exit_signal + stop_signal;
    }
    return is_logged ? check_exit_code(arguments, result.verdict, result.margin) : exit_input;
}

} // namespace berth
