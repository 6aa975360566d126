#include "options.h"

#include <CLI/CLI.hpp>

#include "../rig/rig_file.h"
#include "../version.h"
#include "live_sender.h"

namespace berth
{

target_options parse_options(int argc, char **argv)
{
    target_options options;
    CLI::App app{"berth-target: the loop on real buses and lines"};
    app.set_version_flag("--version", std::string("berth ") + version());
    app.add_option("RIG", options.rig, "a shipped rig or the path of a rig file; [target] says how it is wired")
        ->required();
    app.add_option("LOG", options.log_path, "ULog file; default: target.log_path of the rig, or none");
    app.add_option("--set", options.overrides, "override a key of the rig: section.key=value; may be given again")
        ->type_name("KEY=VALUE")
        ->option_text("KEY=VALUE") /* one each time: help that promises several is wrong */
        ->take_all()
        ->allow_extra_args(false);
    app.add_flag("--check", options.check_only, "say what this machine is fit for, and stop");
    app.add_option("--jitter", options.jitter_path, "write histograms of the loop's timing when it ends (JSON)")
        ->type_name("FILE");
    app.add_option(
           "--live", options.live_address,
           "send samples to `berth live` there, as UDP datagrams; the thread of the log does it, not the loop")
        ->type_name("ADDRESS:PORT");
    app.add_option("--stage", options.stage,
                   "a stage of commissioning: watch, tare, step, shadow, ramp or run; refused until those before it "
                   "were passed or waived")
        ->check(CLI::IsMember({"watch", "tare", "step", "shadow", "ramp", "run"}).description(""))
        ->type_name("STAGE");
    app.add_option(
           "--record", options.record_path,
           "record of the stages, as `berth commission` writes it; default: commissioning.json beside the log")
        ->type_name("FILE")
        ->needs("--stage");
    app.add_option("--ramp-s", options.ramp_s, "stage ramp: time in which the feedback rises from 0 to 1")
        ->check(CLI::Range(1.0, 3600.0).description(""))
        ->type_name("S")
        ->capture_default_str();
    app.add_flag("--without-realtime", options.without_realtime,
                 "enable motion even without real-time scheduling; the log says so");
    app.add_flag("--without-buses", options.without_buses,
                 "no CAN and no lines, so no motion: only the loop's timing");
    app.add_flag("--until-stopped", options.until_stopped,
                 "go on after run.duration_s, until SIGTERM, SIGINT or SIGHUP");
    app.add_option("--rotate-MB", options.rotation.part_MB,
                   "begin a new log file at this size; the earlier ones get numbers, as LOG.1.ulg")
        ->check(CLI::PositiveNumber)
        ->type_name("MB");
    app.add_option("--rotate-h", options.rotation.part_h, "begin a new log file at this age")
        ->check(CLI::PositiveNumber)
        ->type_name("HOURS");
    app.add_option("--keep-MB", options.rotation.total_MB,
                   "remove the oldest numbered log files beyond this size of all; needs --rotate-MB")
        ->check(CLI::PositiveNumber)
        ->type_name("MB")
        ->needs("--rotate-MB");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        if (error.get_exit_code() != 0) {
            throw input_error(std::string(argv[0]) + ": " + error.what() + "; see --help");
        }
        app.exit(error);
        options.is_done = true;
    }
    if (app.count("--live") > 0 && !options.is_done) {
        parse_live_address(options.live_address);
    }
    if (options.rotation.total_MB > 0.0 && options.rotation.total_MB < 2.0 * options.rotation.part_MB) {
        throw input_error(std::string(argv[0]) + ": --keep-MB is less than two files of --rotate-MB; give more");
    }
    return options;
}

} // namespace berth
